"""A point cloud seen from above, made into triangles."""

import numpy as np
from scipy.spatial import Delaunay

_CELLS = 250
"""Grid cells along the longer side: finer than the depth images, coarse enough to average noise away."""
_LONGEST_EDGE = 4.0
"""Triangles with an edge longer than this many times the typical one bridge a gap: left out."""


def grid_points(points_mm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangulate a cloud seen from above.

    Points that share a cell of a fine grid are first replaced by their median, so that noise and overlapping
    frames of a scan do not make spikes; what is undercut is not seen.

    Args:
        points_mm: Points [mm], z up, shape [n, 3], float.

    Returns:
        Vertices [mm], shape [k, 3], and triangles counter-clockwise seen from above, shape [m, 3].
    """
    low = points_mm[:, :2].min(axis=0)
    cell = np.ptp(points_mm[:, :2], axis=0).max() / _CELLS
    key = np.floor((points_mm[:, :2] - low) / cell).astype(np.int64)
    _, group, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    group = group.ravel()
    order = np.lexsort((points_mm[:, 2], group))
    middle = np.cumsum(count) - count + count // 2
    mean = np.stack([np.bincount(group, points_mm[:, i]) for i in range(2)], axis=1) / count[:, None]
    vertices = np.column_stack([mean, points_mm[order[middle], 2]])
    triangles = Delaunay(vertices[:, :2]).simplices
    corners = vertices[triangles, :2]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    return vertices, triangles[edges <= _LONGEST_EDGE * np.median(edges)]
