"""An alignment field given at the vertices of the flat film's mesh, read anywhere on it."""

from dataclasses import dataclass

import igl
import numpy as np

from planner.errors import InputError
from planner.toolpaths.dense.director_field import Reading


@dataclass(frozen=True, kw_only=True, eq=False)
class MeshField:
    """Alignment vectors q = e (cos 2 theta, sin 2 theta), linear in each triangle of the flat film."""

    points_mm: np.ndarray
    """Vertices [mm], shape [n, 2], float."""
    triangles: np.ndarray
    """Vertex indices, shape [m, 3], int."""
    q: np.ndarray
    """Alignment vectors at the vertices, shape [n, 2], float."""

    def __post_init__(self) -> None:
        """Refuse arrays that do not belong together."""
        points, q = np.asarray(self.points_mm), np.asarray(self.q)
        if points.ndim != 2 or points.shape[1] != 2 or q.shape != points.shape:
            raise InputError(
                f"a field for dense lines has points of shape {points.shape} and q of shape {q.shape}, allowed are "
                "equal shapes [n, 2]; give one vector (cos 2 theta, sin 2 theta) times its strength at each vertex"
            )
        if not (np.isfinite(points).all() and np.isfinite(q).all()):
            raise InputError(
                "a field for dense lines has values that are not finite, allowed are finite numbers; set q to 0 where "
                "nothing is wanted"
            )

    @property
    def box_mm(self) -> np.ndarray:
        """Lowest and highest corner of the film [mm], shape [2, 2]."""
        return np.stack([self.points_mm.min(axis=0), self.points_mm.max(axis=0)])

    def at(self, xy_mm: np.ndarray) -> Reading:
        """Read the field at points [mm], shape [n, 2]."""
        corners = np.ascontiguousarray(self.points_mm, dtype=float)
        faces = np.ascontiguousarray(self.triangles, dtype=np.int64)
        found = igl.point_mesh_squared_distance(np.ascontiguousarray(xy_mm, dtype=float), corners, faces)
        squared, owner, nearest = (np.asarray(part) for part in found)
        a, b, c = (corners[faces[owner, k]] for k in range(3))
        area = _cross(b - a, c - a)
        # Slivers at a straight edge may have no area: they give the value of their first corner.
        area[area == 0] = np.inf
        second, third = _cross(nearest - a, c - a) / area, _cross(b - a, nearest - a) / area
        weights = np.stack([1.0 - second - third, second, third], axis=1)
        return Reading(np.einsum("nk,nki->ni", weights, self.q[faces[owner]]), np.sqrt(squared))


def _cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
