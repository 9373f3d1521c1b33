"""The film on its way up the ramp, where it chooses the shape that it will end in.

At 150 C nearly every film that has snapped could as well stand where it was designed to: the ramp from flat lost the
way long before. A dome of the design may hang down at first, on a branch of its own, and come over with a snap; errors
of the process delay that, or let one side of the dome snap without the other. Where that is decided the film is soft.
At a few shares g of its activation a design therefore pays

    WEIGHT sum over vertices of share ((z_g - g z)^2 + NOISE_WEIGHT Var z_g) / 2,

with the heights z_g of the equilibrium on the ramp and those of the hot shape, z, which are held. The square asks for
the sense of the target's bends in time, its contractions being g of the hot ones; the variance, to first order in the
errors, for a way out of the places where two shapes part. Height and tilt of the whole film count nothing.
"""

import numpy as np

from planner.errors import SolverError
from twin.inverse.expected_loss import NOISE_WEIGHT, ExpectedLoss
from twin.inverse.noise import ProcessErrors
from twin.inverse.refine import Design
from twin.inverse.world import World

PLACES = (0.35, 0.5, 0.65, 0.8)
"""Shares of the activation: shapes of faces part between them, and what is soft at one is soft beside it."""
WEIGHT_PER_MM2 = 0.15
"""Half a millimetre, as designs of faces end with, costs as much as 0.02 of similarity at each place."""
WAYS = 2
"""Soft ways that are followed at each place: where two shapes part there is one that matters."""


class OnTheWay:
    """What one design after the other pays on its ramp."""

    def __init__(self, worlds: list[World], errors: ProcessErrors) -> None:
        """Prepare.

        Args:
            worlds: of the film, one for each of `PLACES`, for this use alone: their activation is changed.
            errors: of the process.
        """
        self._worlds, self._errors = worlds, errors
        self._hot = worlds[0].activation
        for world, share in zip(worlds, PLACES, strict=True):
            world.activation = share * self._hot
        self._cost = _Heights(worlds[0])
        self._begun: Design | None = None
        self.end_mm = np.empty(0)
        """Where the ramp of the last design that `begin` was given ends [mm], shape [n, 3]."""

    def begin(self, design: Design) -> np.ndarray:
        """Find a design's films on its ramp [mm], shape [places, n, 3].

        Raises:
            SolverError: if the film cannot be heated from flat, or is not stable at one of the places.
        """
        if design is not self._begun:
            self._begun = None
            states = self._worlds[0].states(design.q)
            self.end_mm = states[-1][1]
            self._start_mm = np.stack([self._state(world, design.q, states) for world in self._worlds])
            height = design.shape.vertices_mm[:, 2]
            self._wanted_mm = [share * height for share in PLACES]
            self._losses = [
                ExpectedLoss(world, self._errors, self._cost, design.q, ways=WAYS) for world in self._worlds
            ]
            self._begun = design
        return self._start_mm

    def _state(self, world: World, q: np.ndarray, states: list[tuple[float, np.ndarray]]) -> np.ndarray:
        """Return the film at a world's activation, from the state of its ramp before, and linearise there."""
        before = [vertices for at, vertices in states if at <= world.activation]
        vertices = world.balance(q, before[-1])
        self._linearise(world, q, vertices)
        return vertices

    def at(self, q: np.ndarray, near_mm: np.ndarray) -> np.ndarray:
        """Work out what an alignment [layers, m, 2] pays; returns its films there, near others [mm], [places, n, 3].

        Raises:
            SolverError: if there is no equilibrium at one of the places, or none that is stable.
        """
        films, self.value, self._by_vertices = np.empty_like(near_mm), 0.0, np.zeros_like(near_mm)
        for index, (world, loss, wanted) in enumerate(zip(self._worlds, self._losses, self._wanted_mm, strict=True)):
            vertices = films[index] = world.balance(q, near_mm[index])
            self._linearise(world, q, vertices)
            loss.at(q, vertices)
            off = np.zeros_like(vertices)
            off[:, 2] = vertices[:, 2] - wanted
            self._by_vertices[index] = self._cost.curve(off)
            self.value += 0.5 * float((off * self._by_vertices[index]).sum()) + NOISE_WEIGHT * loss.value
        return films

    def gradient(self) -> np.ndarray:
        """Return the gradient by the alignment, shape [layers, m, 2]."""
        whole = 0.0
        for world, loss, own in zip(self._worlds, self._losses, self._by_vertices, strict=True):
            by_q, by_vertices = (NOISE_WEIGHT * part for part in loss.gradient())
            whole = whole + by_q + world.pull(own + by_vertices)
        return np.asarray(whole)

    def push(self, dq: np.ndarray) -> np.ndarray:
        """Return how the vertices move [mm], shape [places, n, 3], for a change of the alignment."""
        return np.stack([world.push(dq) for world in self._worlds])

    def close(self) -> None:
        """Release the solvers' memory."""
        for world in self._worlds:
            world.newton.close()

    def _linearise(self, world: World, q: np.ndarray, vertices_mm: np.ndarray) -> None:
        if not world.linearise(q, vertices_mm):
            raise SolverError("on the way up: the equilibrium is not stable.")


class _Heights:
    """The mean square of heights, the film's own height and tilt taken out, times WEIGHT_PER_MM2."""

    def __init__(self, world: World) -> None:
        flat = world.newton.shell.film.flat_mm
        self._share = world.vertex_share[:, 0]
        root = np.sqrt(self._share)
        basis = np.column_stack((np.ones(len(flat)), flat - flat.mean(axis=0)))
        self._rigid = np.linalg.qr(root[:, None] * basis)[0] / root[:, None]

    def flattened(self, height_mm: np.ndarray) -> np.ndarray:
        """Return heights [n] without the plane that fits them best."""
        return height_mm - self._rigid @ (self._rigid.T @ (self._share * height_mm))

    def curve(self, displacement_mm: np.ndarray) -> np.ndarray:
        """Return the curvature times a displacement, both [n, 3]."""
        by_vertices = np.zeros_like(displacement_mm)
        by_vertices[:, 2] = WEIGHT_PER_MM2 * self._share * self.flattened(displacement_mm[:, 2])
        return by_vertices
