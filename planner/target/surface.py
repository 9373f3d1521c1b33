"""Fast look-ups of height, slope and membership on a target."""

import numpy as np
from scipy import ndimage

from planner.target.local_planes import fill_heights, local_planes
from planner.target.outline import signed_distance
from planner.target.target import Target

MARGIN_CELLS = 3
"""How far the heights are continued beyond the grid and the outline [cells]."""


class Surface:
    """A target as a function of x and y: bilinear between nodes, continued a little beyond the outline."""

    def __init__(self, target: Target) -> None:
        margin = MARGIN_CELLS
        self.spacing_mm = (float(target.x_mm[1] - target.x_mm[0]), float(target.y_mm[1] - target.y_mm[0]))
        self._origin = np.array([target.x_mm[0], target.y_mm[0]]) - margin * np.array(self.spacing_mm)
        z = np.pad(target.z_mm, margin, constant_values=np.nan)
        self._known = np.isfinite(z)
        near = ndimage.binary_dilation(self._known, iterations=margin)
        # Far outside any height does; a number keeps the look-up free of NaN.
        self._z = np.nan_to_num(fill_heights(z, near, spacing_mm=self.spacing_mm), nan=0.0)
        self._clearance = self._signed_clearance(target.outline_mm)
        self._slopes: dict[float, tuple[np.ndarray, np.ndarray]] = {}

    def inside(self, xy_mm: np.ndarray) -> np.ndarray:
        """Tell which points lie within the outline (or on it), shape [..., 2] -> [...], bool."""
        return self._look_up(self._clearance, xy_mm) >= -1e-6

    def clearance_mm(self, xy_mm: np.ndarray) -> np.ndarray:
        """Distance to the outline [mm], positive inside, cut off at three cells, shape [..., 2] -> [...]."""
        return self._look_up(self._clearance, xy_mm)

    def height(self, xy_mm: np.ndarray) -> np.ndarray:
        """Height above the lowest point [mm], NaN outside the outline, shape [..., 2] -> [...]."""
        return np.where(self.inside(xy_mm), self._look_up(self._z, xy_mm), np.nan)

    def extended_height(self, xy_mm: np.ndarray) -> np.ndarray:
        """Height [mm], continued by planes up to three cells beyond the outline, shape [..., 2] -> [...]."""
        return self._look_up(self._z, xy_mm)

    def gradient(self, xy_mm: np.ndarray, *, smoothing_mm: float = 0.25) -> np.ndarray:
        """Slope (dz/dx, dz/dy) [1], NaN outside the outline, shape [..., 2] -> [..., 2].

        Args:
            xy_mm: Points seen from above [mm].
            smoothing_mm: Standard deviation of the Gaussian window over which planes are fitted [mm]; it is
                at least 0.6 grid cells, so that a plane has enough neighbours.

        """
        sigma = max(float(smoothing_mm), 0.6 * max(self.spacing_mm))
        if sigma not in self._slopes:
            planes = local_planes(self._z, self._known.astype(float), spacing_mm=self.spacing_mm, sigma_mm=sigma)
            weights = (planes.support > 1e-3).astype(float)
            self._slopes[sigma] = (
                np.where(weights > 0, planes.slope_x, 0.0),
                np.where(weights > 0, planes.slope_y, 0.0),
            )
        slope_x, slope_y = self._slopes[sigma]
        inside = self.inside(xy_mm)[..., None]
        slopes = np.stack((self._look_up(slope_x, xy_mm), self._look_up(slope_y, xy_mm)), axis=-1)
        return np.where(inside, slopes, np.nan)

    def _look_up(self, field: np.ndarray, xy_mm: np.ndarray) -> np.ndarray:
        """Interpolate a node field bilinearly; beyond the grid its border value holds."""
        index = (np.asarray(xy_mm, dtype=float) - self._origin) / self.spacing_mm
        row_column = index.reshape(-1, 2).T[::-1]
        values = ndimage.map_coordinates(field, row_column, order=1, mode="nearest")
        return np.asarray(values).reshape(index.shape[:-1])

    def _signed_clearance(self, outline_mm: np.ndarray) -> np.ndarray:
        """Signed distance of the nodes to the outline [mm], exact near it, cut off elsewhere."""
        reach = MARGIN_CELLS * min(self.spacing_mm)
        clearance = np.where(self._known, reach, -reach)
        reach_nodes = MARGIN_CELLS + 1
        outer = ndimage.binary_dilation(self._known, iterations=reach_nodes)
        inner = ndimage.binary_erosion(self._known, iterations=reach_nodes)
        rows, columns = np.nonzero(np.logical_and(outer, np.logical_not(inner)))
        nodes = self._origin + np.column_stack((columns, rows)) * self.spacing_mm
        clearance[rows, columns] = np.clip(signed_distance(nodes, outline_mm), -reach, reach)
        return clearance
