"""A field on a square grid, continued beyond the region that is to be scratched."""

from dataclasses import dataclass
from typing import cast

import numpy as np
import scipy.fft
from scipy.ndimage import distance_transform_edt, gaussian_filter, map_coordinates

from planner.toolpaths.dense.director_field import DirectorField

CELLS_PER_LINE = 5
"""Grid cells across a line: the stripes' third harmonic, which the cubic term makes, does not fold back."""
RIM_LINES = 4.0
"""Lines' widths of empty grid around the film: the Fourier transform is periodic."""
BLEND_LINES = 1.5
"""Distance from the region, in lines' widths, at which its continued directions are fully smoothed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FieldGrid:
    """Directors at the nodes of a grid, and how far each node is from what is to be scratched."""

    origin_mm: np.ndarray
    """First node [mm], shape [2]."""
    cell_mm: float
    theta_rad: np.ndarray
    """Director angle, everywhere, modulo pi [rad], shape [nx, ny]."""
    outside_mm: np.ndarray
    """Signed distance from the wanted region, negative in it [mm], shape [nx, ny]."""
    beyond_film_mm: np.ndarray
    """Distance from the film, 0 on it [mm], shape [nx, ny]."""

    def read(self, values: np.ndarray, xy_mm: np.ndarray) -> np.ndarray:
        """Interpolate nodal values linearly at points [mm], shape [n, 2]."""
        return map_coordinates(values, ((xy_mm - self.origin_mm) / self.cell_mm).T, order=1, mode="nearest")


def field_grid(field: DirectorField, line_width_mm: float, least: float) -> FieldGrid:
    """Sample a field; where `|q|` < `least` nothing is wanted and the region's directions go on smoothly."""
    cell, rim = line_width_mm / CELLS_PER_LINE, RIM_LINES * line_width_mm
    low, high = field.box_mm[0] - rim, field.box_mm[1] + rim
    size = tuple(_fast_length(int(np.ceil(extent / cell)) + 1) for extent in high - low)
    axes = [low[k] + cell * np.arange(size[k]) for k in (0, 1)]
    reading = field.at(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2))
    q, beyond = reading.q.reshape(*size, 2), reading.beyond_mm.reshape(size)
    strength = np.linalg.norm(q, axis=-1)
    wanted = (strength >= least) & (beyond < 1e-9)
    if not wanted.any():
        outside = np.full(size, np.inf)
        return FieldGrid(
            origin_mm=low, cell_mm=cell, theta_rad=np.zeros(size), outside_mm=outside, beyond_film_mm=beyond
        )
    away, nearest = cast(tuple[np.ndarray, np.ndarray], distance_transform_edt(~wanted, return_indices=True))
    # The border runs half a cell from the nodes on either side of it.
    outside = cell * np.where(wanted, 0.5 - cast(np.ndarray, distance_transform_edt(wanted)), away - 0.5)
    unit = (q / np.maximum(strength, 1e-300)[..., None])[nearest[0], nearest[1]]
    smooth = gaussian_filter(unit, sigma=(BLEND_LINES * CELLS_PER_LINE, BLEND_LINES * CELLS_PER_LINE, 0))
    share = np.clip(outside / (BLEND_LINES * line_width_mm), 0, 1)[..., None]
    double = (1 - share) * unit + share * smooth
    theta = np.arctan2(double[..., 1], double[..., 0]) / 2
    return FieldGrid(origin_mm=low, cell_mm=cell, theta_rad=theta, outside_mm=outside, beyond_film_mm=beyond)


def _fast_length(count: int) -> int:
    return cast(int, scipy.fft.next_fast_len(count, real=True))
