"""Closest points on a surface, given as triangles or as a bare point cloud."""

from functools import lru_cache

import igl
import numpy as np
from scipy.spatial import KDTree

from planner.target import Target


class ClosestPoints:
    """Answer closest-point questions about one surface, and sample it evenly.

    Triangles answer exactly (a tree of boxes, by libigl); a cloud answers with its nearest point.
    """

    def __init__(self, vertices_mm: np.ndarray, triangles: np.ndarray | None = None) -> None:
        """Build the search tree.

        Args:
            vertices_mm: Vertices or cloud points [mm], shape [n, 3], float.
            triangles: Vertex indices, shape [m, 3], int; None for a cloud.
        """
        self.vertices_mm = np.ascontiguousarray(vertices_mm, dtype=float)
        self.triangles = None if triangles is None else np.ascontiguousarray(triangles, dtype=np.int64)
        if self.triangles is None:
            self._cloud = KDTree(self.vertices_mm)
        else:
            self._boxes = igl.AABB()
            self._boxes.init(self.vertices_mm, self.triangles)

    def find(self, points_mm: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Closest surface points [mm], their distances [mm] and triangle (or cloud point) indices."""
        if self.triangles is None:
            nearest = self._cloud.query(points_mm)
            distance, index = np.asarray(nearest[0]), np.asarray(nearest[1])
            return self.vertices_mm[index], distance, index
        found = self._boxes.squared_distance(
            self.vertices_mm, self.triangles, np.ascontiguousarray(points_mm, dtype=float)
        )
        squared, index, closest = (np.asarray(part) for part in found)
        return closest, np.sqrt(squared), index

    @property
    def area_vectors(self) -> np.ndarray:
        """Area times normal of each triangle [mm2], shape [m, 3]; empty for a cloud."""
        if self.triangles is None:
            return np.empty((0, 3))
        a, b, c = (self.vertices_mm[self.triangles[:, i]] for i in range(3))
        return np.cross(b - a, c - a) / 2.0

    def sample(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Spread about `count` points over the surface, evenly by area, the same ones at each call.

        Returns:
            Points [mm], shape [k, 3], and the triangle (or cloud point) each lies on, shape [k].
        """
        if self.triangles is None:
            index = _thin(self.vertices_mm, count)
            return self.vertices_mm[index], index
        # Systematic sampling along the running area; golden-ratio steps spread points inside triangles.
        area = np.cumsum(np.linalg.norm(self.area_vectors, axis=1))
        index = np.searchsorted(area, (np.arange(count) + 0.5) / count * area[-1])
        index = np.minimum(index, len(area) - 1)
        u, v = (np.arange(count)[:, None] * (0.7548776662466927, 0.5698402909980532) % 1.0).T
        flip = u + v > 1.0
        u, v = np.where(flip, 1.0 - u, u), np.where(flip, 1.0 - v, v)
        a, b, c = (self.vertices_mm[self.triangles[index, i]] for i in range(3))
        return a + u[:, None] * (b - a) + v[:, None] * (c - a), index


def grid_triangles(x_mm: np.ndarray, y_mm: np.ndarray, z_mm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangulate a height grid; cells with a NaN corner are left out.

    Returns:
        Vertices [mm], shape [n, 3], and triangles counter-clockwise seen from above, shape [m, 3].
    """
    index = np.arange(z_mm.size).reshape(z_mm.shape)
    a, b = index[:-1, :-1].ravel(), index[:-1, 1:].ravel()
    c, d = index[1:, 1:].ravel(), index[1:, :-1].ravel()
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    triangles = triangles[np.isfinite(z_mm.ravel()[triangles]).all(axis=1)]
    used, triangles = np.unique(triangles, return_inverse=True)
    x, y = np.meshgrid(x_mm, y_mm)
    vertices = np.stack([x.ravel(), y.ravel(), z_mm.ravel()], axis=1)[used]
    return vertices, triangles.reshape(-1, 3)


@lru_cache(maxsize=4)
def target_surface(target: Target) -> ClosestPoints:
    """Closest points on a target; its grid is thinned to steps of at least 0.25 mm.

    Kept for the last few targets: a search registers hundreds of shapes to one.
    """
    stride = max(1, round(0.25 / float(target.x_mm[1] - target.x_mm[0])))
    grids = target.x_mm[::stride], target.y_mm[::stride], target.z_mm[::stride, ::stride]
    return ClosestPoints(*grid_triangles(*grids))


def _thin(points: np.ndarray, count: int) -> np.ndarray:
    """Indices of about `count` points, one for each occupied cell of a cubic grid."""
    cell = np.ptp(points, axis=0).max() / np.sqrt(count)
    keys = np.floor((points - points.min(axis=0)) / max(cell, 1e-12)).astype(np.int64)
    return np.sort(np.unique(keys, axis=0, return_index=True)[1])
