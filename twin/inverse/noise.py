"""Films that noise has made of one design: a few that stand for the process in robust design.

The errors are those of `twin.batch.ProcessNoise`, each layer turned as a whole: linear in the alignment, so that the
adjoint goes through them.
"""

import numpy as np
import scipy.sparse as sp
from scipy.spatial import Delaunay, KDTree

from twin.batch import ProcessNoise
from twin.film import Film
from twin.inverse.distortion import Distortion

PAIRS = 2
"""Noise is drawn in pairs of opposite sign, so that its mean is exactly none."""


def noise_worlds(film: Film, noise: ProcessNoise, *, seed: int) -> tuple[Distortion, ...]:
    """Return what noise makes of designs on the mesh of a film: the same ones for the same seed."""
    rng = np.random.default_rng(seed)
    layers, centre = len(film.contraction), film.flat_mm[film.triangles].mean(axis=1)
    mesh, tree = Delaunay(centre), KDTree(centre)
    made = []
    for _ in range(PAIRS):
        strength = noise.strain * rng.normal() + noise.layer_strain * rng.normal(size=layers)
        turn, shift = (
            noise.direction_rad * rng.normal(size=layers),
            noise.registration_mm * rng.normal(size=(layers, 2)),
        )
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
