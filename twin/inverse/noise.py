"""The errors of the process as one covariance of a film's alignment.

`twin.batch.ProcessNoise` draws errors; here are their second moments, to first order in the errors. With s a linear
functional of the alignment q, the variance that the process gives it is s^t Cov(q) s, where

- the strain of the whole film, that of one layer, and its shift along x and y each add (n . s) n for what one
  standard deviation of it changes, n = N q with N linear;
- the directions of a layer add sigma^2 t(x) k(x - x') t(x') with t = 2 q_perp . s and their correlation k.
"""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from scipy.spatial import Delaunay, KDTree

from twin.batch import ProcessNoise, noisy_films, smooth_field
from twin.film import Film

FIELDS = 24
"""Random fields of directions that stand for all of them where single errors are asked for."""
CELLS_PER_LENGTH, MOST_CELLS = 4, 400
"""Fineness of the grid on which correlated directions are summed up: of the correlation's length, of the film."""

BORNE = 0.5
"""Deviations that a robust design is searched for, over those of the process that it must bear: searches for the whole
ones run into snaps so early that their designs bear the whole ones worse, see decision 0013."""
BORNE_LENGTH_MM = 10.0
"""Least distance over which directions go wrong in that search: shorter ones let a film be soft in ways that larger
moves than the first order's find, see decision 0014."""


def searched(noise: ProcessNoise) -> ProcessNoise:
    """Return the noise that a design is searched for, so that it bears another."""
    length_mm = max(noise.direction_length_mm, BORNE_LENGTH_MM)
    return replace(noise.scaled(BORNE), direction_length_mm=length_mm)


class ProcessErrors:
    """The errors of `ProcessNoise` on one mesh, to first order."""

    def __init__(self, film: Film, noise: ProcessNoise, *, seed: int) -> None:
        """Prepare the mesh of a film, and draw the fields of directions of `examples`: the same for the same seed."""
        rng = np.random.default_rng(seed)
        centre = film.flat_mm[film.triangles].mean(axis=1)
        self._layers, self._noise, self._seed = len(film.contraction), noise, seed
        self._mesh, self._tree = Delaunay(centre), KDTree(centre)
        self._shifts = [self._moved(shift) for shift in noise.registration_mm * np.eye(2)]
        self._to_grid, self._correlation = _on_grid(centre, noise.direction_length_mm)
        self._turns = noise.direction_rad * np.stack(
            [[smooth_field(centre, noise.direction_length_mm, rng) for _ in range(self._layers)] for _ in range(FIELDS)]
        )

    def kinds(self, q: np.ndarray) -> dict[str, list[np.ndarray]]:
        """Return changes of the alignment [layers, m, 2] by the kind of error that makes them.

        Their outer products add up to its covariance, exactly but for the directions, which fields drawn at random
        stand for.
        """
        found: dict[str, list[np.ndarray]] = {
            "strain": [self._noise.strain * q],
            "layer_strain": [],
            "registration": [],
        }
        for layer in range(self._layers):
            for number, change in enumerate(self._of_layer(q[layer])):
                kind = found["registration" if number else "layer_strain"]
                kind.append(np.zeros_like(q))
                kind[-1][layer] = change
        turned = 2.0 / np.sqrt(FIELDS) * self._turns[..., None] * _across(q)
        return {**found, "direction": list(turned)}

    def examples(self, q: np.ndarray) -> list[np.ndarray]:
        """Return the changes of all kinds."""
        return [change for kind in self.kinds(q).values() for change in kind]

    def draw(self, film: Film, count: int, number: int) -> list[np.ndarray]:
        """Return the alignment of films with random errors, not to first order; other ones for each number."""
        seed = int(np.random.SeedSequence((self._seed, number)).generate_state(1)[0])
        return [noisy.alignment for noisy in noisy_films(film, self._noise, count, seed)]

    def variance(self, q: np.ndarray, s: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """Return s^t Cov(q) s, Cov(q) s and half the gradient by q with s held; s and both [layers, m, 2] like q."""
        common = self._noise.strain * float((q * s).sum())
        value = common**2
        spread, by_q = common * self._noise.strain * q, common * self._noise.strain * s
        across = _across(q)
        for layer, own in enumerate(s):
            # strain first, then the shifts, as in `_of_layer`
            for change, back in zip(
                self._of_layer(q[layer]),
                (self._noise.layer_strain * own, *(moved.T @ own - own for moved in self._shifts)),
                strict=True,
            ):
                along = float((change * own).sum())
                value += along**2
                spread[layer] += along * change
                by_q[layer] += along * back
            turned = 2.0 * self._noise.direction_rad * (across[layer] * own).sum(axis=1)
            across_side, up_side = self._correlation
            on_grid = (self._to_grid @ turned).reshape(len(across_side), len(up_side))
            summed = self._to_grid.T @ (across_side @ on_grid @ up_side).ravel()
            value += float(turned @ summed)
            weight = 2.0 * self._noise.direction_rad * summed[:, None]
            spread[layer] += weight * across[layer]
            by_q[layer] -= weight * _across(own)
        return value, spread, by_q

    def _of_layer(self, q: np.ndarray) -> list[np.ndarray]:
        """Return what one standard deviation of a layer's strain and of its shifts changes, each [m, 2]."""
        return [self._noise.layer_strain * q, *(moved @ q - q for moved in self._shifts)]

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


def _across(q: np.ndarray) -> np.ndarray:
    """Return alignment vectors turned by a right angle, [..., 2]: half of what a turn of one radian changes."""
    return np.stack((-q[..., 1], q[..., 0]), axis=-1)


def _on_grid(points_mm: np.ndarray, length_mm: float) -> tuple[sp.csr_matrix, tuple[np.ndarray, np.ndarray]]:
    """Return the bilinear map of points [m, 2] to a grid, [across up, m], and the nodes' correlation along each side.

    The correlation of two nodes is the product of those of their places along the sides.
    """
    low, extent = points_mm.min(axis=0), np.ptp(points_mm, axis=0)
    longest = float(extent.max())
    cell = max(length_mm / CELLS_PER_LENGTH, longest / MOST_CELLS) if np.isfinite(length_mm) else longest
    place = (points_mm - low) / cell
    corner = np.floor(place).astype(int)
    counts = corner.max(axis=0) + 2
    part = place - corner
    entries = [
        (
            (corner[:, 0] + right) * counts[1] + corner[:, 1] + above,
            np.abs(1 - right - part[:, 0]) * np.abs(1 - above - part[:, 1]),
        )
        for right in (0, 1)
        for above in (0, 1)
    ]
    to_grid = sp.csr_matrix(
        (
            np.concatenate([weight for _, weight in entries]),
            (np.concatenate([node for node, _ in entries]), np.tile(np.arange(len(place)), 4)),
        ),
        shape=(counts[0] * counts[1], len(place)),
    )
    steps = [cell * (np.arange(count)[:, None] - np.arange(count)) for count in counts]
    across, up = (np.exp(-0.5 * (step / length_mm) ** 2) for step in steps)
    return to_grid, (across, up)
