"""A director field given by a dense cloud of points that all want to be scratched."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates
from scipy.spatial import KDTree

from planner.toolpaths.dense.director_field import Reading

CELLS_PER_LINE = 4
SMOOTHING_LINES = 0.5
"""Standard deviation of the mean of directors, in line widths: what is finer cannot be scratched."""
CLOUD_LEAST = 0.7
"""Strength at the cloud's own border: the mean reaches half a smoothing length less far than the widened cloud."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CloudField:
    """Smoothed directors on a grid; `|q|` is the share of points near by, 1 inside the cloud and 0 far from it."""

    origin_mm: np.ndarray
    """First node [mm], shape [2]."""
    cell_mm: float
    q: np.ndarray
    """Alignment vectors at the nodes, shape [nx, ny, 2], float."""

    @property
    def box_mm(self) -> np.ndarray:
        """Lowest and highest corner of the grid [mm], shape [2, 2]."""
        return np.stack([self.origin_mm, self.origin_mm + self.cell_mm * (np.array(self.q.shape[:2]) - 1)])

    def at(self, xy_mm: np.ndarray) -> Reading:
        """Read the field at points [mm], shape [n, 2]: 0 beyond the grid, which knows no film's edge."""
        places = ((xy_mm - self.origin_mm) / self.cell_mm).T
        q = [map_coordinates(self.q[..., k], places, order=1, mode="constant") for k in (0, 1)]
        return Reading(np.stack(q, axis=1), np.zeros(len(xy_mm)))


def cloud_field(points_mm: np.ndarray, direction_rad: np.ndarray, line_width_mm: float) -> CloudField:
    """Average the directors of a cloud.

    Args:
        points_mm: cloud on the film, less than a quarter of a line width apart [mm], shape [n, 2], n >= 1.
        direction_rad: director at each point, modulo pi [rad], shape [n].
        line_width_mm: width that a pass aligns [mm].

    """
    cell, rim = line_width_mm / CELLS_PER_LINE, 2 * line_width_mm
    low = points_mm.min(axis=0) - rim
    size = np.ceil((points_mm.max(axis=0) + rim - low) / cell).astype(int) + 1
    nodes = low + cell * np.stack(np.indices(size), axis=-1)
    near = KDTree(points_mm).query(nodes.reshape(-1, 2), distance_upper_bound=line_width_mm / 4)[0]
    smoothing = SMOOTHING_LINES * CELLS_PER_LINE
    share = gaussian_filter(np.isfinite(near).reshape(size).astype(float), smoothing)
    owner = np.ravel_multi_index(tuple(np.rint((points_mm - low) / cell).astype(int).T), tuple(size))
    double = np.stack([np.cos(2 * direction_rad), np.sin(2 * direction_rad)])
    total = np.stack([np.bincount(owner, part, minlength=size.prod()).reshape(size) for part in double], axis=-1)
    mean = gaussian_filter(total, (smoothing, smoothing, 0))
    unit = mean / np.maximum(np.linalg.norm(mean, axis=-1, keepdims=True), 1e-300)
    return CloudField(origin_mm=low, cell_mm=cell, q=share[..., None] * unit)
