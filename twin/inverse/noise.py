"""Films that noise has made of one design: the few that stand for the process in robust design.

The errors of `twin.batch.ProcessNoise` are many, but a film answers most of them in the same few soft ways. With
standard normal errors xi, J what each does to the vertices and C the curvature of the mismatch, it grows by

    xi^t G xi / 2,      G = J^t C J,

on average by half the trace of G. The eigenvectors of G with the largest eigenvalues are the errors that cost most;
films to both sides along each of these stand for all. They depend on the design, and are found again as it changes.
"""

import numpy as np
import scipy.sparse as sp
from scipy.spatial import Delaunay, KDTree

from twin.batch import ProcessNoise, smooth_field
from twin.film import Film
from twin.inverse.distortion import Distortion
from twin.inverse.world import Shape, World

MODES = 2
"""Errors that a robust design is made for at a time; each has two films, of opposite sign."""
AMPLITUDE = 1.28
"""How far these films are off [standard deviations]: at the 10th and the 90th percentile."""
FIELDS = 8
"""Random fields of directions that stand for all of them."""


class NoiseModes:
    """The independent errors of the process on one mesh, in an order of their own."""

    def __init__(self, film: Film, noise: ProcessNoise, *, seed: int) -> None:
        """Draw the fields of directions for the mesh of a film: the same ones for the same seed."""
        rng = np.random.default_rng(seed)
        centre = film.flat_mm[film.triangles].mean(axis=1)
        self._layers, self._noise = len(film.contraction), noise
        self._mesh, self._tree = Delaunay(centre), KDTree(centre)
        self._turns = noise.direction_rad * np.stack(
            [[smooth_field(centre, noise.direction_length_mm, rng) for _ in range(self._layers)] for _ in range(FIELDS)]
        )
        self._shifts = [
            [self._moved(shift) for shift in noise.registration_mm * np.eye(2)] for _ in range(self._layers)
        ]

    def changes(self, q: np.ndarray) -> list[np.ndarray]:
        """Return what one standard deviation of each error changes in alignment vectors, each [layers, m, 2]."""
        made = [self._noise.strain * q]
        for layer in range(self._layers):
            only = np.zeros((self._layers, 1, 1))
            only[layer] = 1.0
            made.append(self._noise.layer_strain * only * q)
            for moved in self._shifts[layer]:
                made.append(only * (moved @ q[layer] - q[layer]))
        across = np.stack((-q[..., 1], q[..., 0]), axis=-1)
        return [*made, *(2.0 / np.sqrt(FIELDS) * turn[..., None] * across for turn in self._turns)]

    def distortion(self, errors: np.ndarray) -> Distortion:
        """Return what errors [standard deviations], in the order of `changes`, do together."""
        common, rest = errors[0], errors[1 : 1 + 3 * self._layers].reshape(self._layers, 3)
        return Distortion(
            strength=1.0 + self._noise.strain * common + self._noise.layer_strain * rest[:, 0],
            turn_rad=np.einsum("f,flm->lm", errors[1 + 3 * self._layers :], self._turns) / np.sqrt(FIELDS),
            shift=tuple(self._moved(self._noise.registration_mm * own) for own in rest[:, 1:]),
        )

    def worst(self, world: World, q: np.ndarray, shape: Shape) -> list[Distortion]:
        """Return the errors that cost a design most, in pairs of opposite sign.

        Args:
            world: the film as intended, linearised at the design.
            q: its alignment, shape [layers, m, 2].
            shape: its equilibrium.
        """
        moves = [world.push(change) for change in self.changes(q)]
        costs = [shape.measured.curve(move) for move in moves]
        gram = np.array([[float((move * cost).sum()) for cost in costs] for move in moves])
        directions = np.linalg.eigh(gram)[1][:, ::-1].T
        return [self.distortion(sign * AMPLITUDE * own) for own in directions[:MODES] for sign in (1.0, -1.0)]

    def _moved(self, shift_mm: np.ndarray) -> sp.csr_matrix:
        """Return the map of values at the triangles' centres to those of the field moved by a shift."""
        points = self._mesh.points - shift_mm
        count = len(points)
        simplex = self._mesh.find_simplex(points)
        inside = simplex >= 0
        transform = self._mesh.transform[simplex[inside]]
        first = np.einsum("kij,kj->ki", transform[:, :2], points[inside] - transform[:, 2])
        weights = np.column_stack((first, 1.0 - first.sum(axis=1)))
        rows, outside = np.flatnonzero(inside), np.flatnonzero(~inside)
        nearest = np.asarray(self._tree.query(points[outside])[1], dtype=int)
        return sp.csr_matrix(
            (
                np.concatenate((weights.ravel(), np.ones(len(outside)))),
                (
                    np.concatenate((np.repeat(rows, 3), outside)),
                    np.concatenate((self._mesh.simplices[simplex[inside]].ravel(), nearest)),
                ),
            ),
            shape=(count, count),
        )
