"""Films that noise has made of one design: a few that stand for the process in robust design."""

import numpy as np
import scipy.sparse as sp
from scipy.spatial import Delaunay, KDTree

from twin.film import Film
from twin.inverse.distortion import Distortion

STRENGTH = 0.05
"""Standard deviation of the contraction's factor, once for the film and once for each layer."""
TURN_RAD = np.deg2rad(5.0)
"""Standard deviation of each layer's direction."""
SHIFT_MM = 0.2
"""Standard deviation of each layer's place, along each axis."""
PAIRS = 2
"""Noise is drawn in pairs of opposite sign, so that its mean is exactly none."""


def noise_worlds(film: Film, *, seed: int) -> tuple[Distortion, ...]:
    """Return what noise makes of designs on the mesh of a film: the same ones for the same seed."""
    rng = np.random.default_rng(seed)
    layers, centre = len(film.contraction), film.flat_mm[film.triangles].mean(axis=1)
    mesh, tree = Delaunay(centre), KDTree(centre)
    made = []
    for _ in range(PAIRS):
        strength = STRENGTH * (rng.normal() + rng.normal(size=layers))
        turn, shift = TURN_RAD * rng.normal(size=layers), SHIFT_MM * rng.normal(size=(layers, 2))
        made += [
            Distortion(
                strength=1.0 + sign * strength,
                turn_rad=sign * turn,
                shift=tuple(_moved(mesh, tree, sign * own) for own in shift),
            )
            for sign in (1.0, -1.0)
        ]
    return tuple(made)


def _moved(mesh: Delaunay, tree: KDTree, shift_mm: np.ndarray) -> sp.csr_matrix:
    """Return the map of values at the points of a mesh to those of the field moved by a shift, linear in between."""
    points = mesh.points - shift_mm
    count = len(points)
    simplex = mesh.find_simplex(points)
    inside = simplex >= 0
    transform = mesh.transform[simplex[inside]]
    first = np.einsum("kij,kj->ki", transform[:, :2], points[inside] - transform[:, 2])
    weights = np.column_stack((first, 1.0 - first.sum(axis=1)))
    rows = np.flatnonzero(inside)
    outside = np.flatnonzero(~inside)
    nearest = np.asarray(tree.query(points[outside])[1], dtype=int)
    return sp.csr_matrix(
        (
            np.concatenate((weights.ravel(), np.ones(len(outside)))),
            (
                np.concatenate((np.repeat(rows, 3), outside)),
                np.concatenate((mesh.simplices[simplex[inside]].ravel(), nearest)),
            ),
        ),
        shape=(count, count),
    )
