"""Carry points and directions from the target to the flat film."""

from typing import NamedTuple

import igl
import numpy as np

from planner.flattening.flattening import Flattening

RIM_MM = 0.05
"""Points this far outside the mesh still belong to it: its straight edges cut the curved outline short by a few um."""


class Located(NamedTuple):
    """For each point the triangle that it lies in, seen from above."""

    triangle: np.ndarray
    """Index of the triangle, -1 outside the mesh, shape [n], int."""
    weights: np.ndarray
    """Barycentric weights, NaN outside, shape [n, 3]."""


def locate(flattening: Flattening, xy_mm: np.ndarray) -> Located:
    """Find the triangle and the barycentric weights of points on the target seen from above [mm], shape [n, 2]."""
    xy = np.asarray(xy_mm, dtype=float).reshape(-1, 2)
    triangle = np.full(len(xy), -1)
    weights = np.full((len(xy), 3), np.nan)
    finite = np.flatnonzero(np.isfinite(xy).all(axis=1))
    if len(finite) == 0:
        return Located(triangle, weights)
    corners = np.ascontiguousarray(flattening.vertices_mm[:, :2], dtype=float)
    faces = np.ascontiguousarray(flattening.triangles, dtype=np.int64)
    squared, nearest, _ = igl.point_mesh_squared_distance(np.ascontiguousarray(xy[finite]), corners, faces)
    near = np.asarray(squared) <= RIM_MM**2
    found = np.asarray(nearest)[near]
    points = xy[finite[near]]
    a, b, c = (corners[faces[found, k]] for k in range(3))
    area = _cross(b - a, c - a)
    second = _cross(points - a, c - a) / area
    third = _cross(b - a, points - a) / area
    triangle[finite[near]] = found
    weights[finite[near]] = np.stack([1.0 - second - third, second, third], axis=1)
    return Located(triangle, weights)


def map_points(flattening: Flattening, xy_mm: np.ndarray, *, located: Located | None = None) -> np.ndarray:
    """Map points of the target seen from above [mm], shape [n, 2], to the film [mm], shape [n, 2].

    Linear in each triangle; NaN outside the mesh. `located` spares the search when the same points are mapped again.
    """
    triangle, weights = locate(flattening, xy_mm) if located is None else located
    corners = flattening.film_mm[flattening.triangles[triangle]]
    # Outside, index -1 picks any triangle and the weights are NaN: the result is NaN.
    return np.einsum("nk,nki->ni", weights, corners)


def map_directions(
    flattening: Flattening, xy_mm: np.ndarray, direction_rad: np.ndarray, *, located: Located | None = None
) -> np.ndarray:
    """Map directions at points of the target to directions on the film, both from +x in [0, pi) [rad], shape [n].

    The direction seen from above belongs to the tangent of the surface above it; each triangle carries its tangents
    to the film by its own linear map. NaN outside the mesh.
    """
    triangle, weights = locate(flattening, xy_mm) if located is None else located
    above = _edge_matrices(flattening.vertices_mm[:, :2], flattening.triangles)
    film = _edge_matrices(flattening.film_mm, flattening.triangles)
    jacobian = (film @ np.linalg.inv(above))[triangle]
    seen = np.stack([np.cos(direction_rad), np.sin(direction_rad)], axis=-1)
    pushed = np.einsum("nij,nj->ni", jacobian, seen)
    angle = np.mod(np.arctan2(pushed[:, 1], pushed[:, 0]), np.pi)
    # A tiny negative angle comes back from the modulo as pi itself.
    angle = np.where(angle >= np.pi, 0.0, angle)
    return np.where(np.isnan(weights[:, 0]), np.nan, angle)


def _edge_matrices(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Edges 0-1 and 0-2 of each triangle as the columns of a matrix, shape [m, 2, 2]."""
    first = points[triangles[:, 1]] - points[triangles[:, 0]]
    second = points[triangles[:, 2]] - points[triangles[:, 0]]
    return np.stack([first, second], axis=-1)


def _cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
