"""The film on its way up the ramp, where it chooses the shape that it will end in.

At 150 C nearly every film that has snapped could as well stand where it was designed to: the ramp from flat lost the
way long before. A dome of the design may hang down at first, on a branch of its own, and come over with a snap; errors
of the process delay that, or let one side of the dome snap without the other. Where that is decided the film is soft.
At the activation g between flat and hot at which the last film that left its design parted from it, or else at that at
which noise moves the design's own film farthest, a design pays

    WEIGHT sum over vertices of share ((z_g - g z)^2 + NOISE_WEIGHT Var z_g) / 2,

with the heights z_g of the equilibrium on the ramp and those of the hot shape, z, which are held. The square asks for
the sense of the target's bends in time, its contractions being g of the hot ones; the variance, to first order in the
errors, for a way out of the place where two shapes part. Height and tilt of the whole film count nothing.
"""

import logging
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from planner.errors import SolverError
from twin.equilibrium import rigid_distance_mm
from twin.inverse.expected_loss import NOISE_WEIGHT, ExpectedLoss
from twin.inverse.noise import ProcessErrors
from twin.inverse.refine import Design
from twin.inverse.world import World

logger = logging.getLogger(__name__)

WEIGHT_PER_MM2 = 0.3
"""Half a millimetre, as designs of faces end with, costs as much as 0.04 of similarity."""
FIRST, LAST = 0.2, 0.9
"""Shares of the design's activation between which the place is looked for."""
PARTED_MM = 1.0
"""A film has parted from a design where a vertex is farther off, rigid motion aside."""
WAYS = 4
"""Soft ways that are followed there: where two shapes part there is one that matters."""

State = tuple[float, np.ndarray]
"""An activation and a film's vertices there [mm], shape [n, 3]."""


class _Begun(NamedTuple):
    """What was found out about one design."""

    design: Design
    parted: float | None
    activation: float
    vertices_mm: np.ndarray


class OnTheWay:
    """What one design after the other pays for the softest place of its ramp."""

    def __init__(self, world: World, errors: ProcessErrors) -> None:
        """Prepare.

        Args:
            world: the film, for this use alone: its activation is changed.
            errors: of the process.
        """
        self._world, self._errors = world, errors
        self._hot = world.activation
        self._cost = _Heights(world)
        self._parted: float | None = None
        self._begun: _Begun | None = None
        self.end_mm = np.empty(0)
        """Where the ramp of the last design that `begin` was given ends [mm], shape [n, 3]."""

    def left_by(self, q: np.ndarray, meant_q: np.ndarray) -> None:
        """Remember where on the ramp a film of alignment q parts from that which it should end beside.

        Raises:
            SolverError: if one of them cannot be heated from flat.
        """
        meant_mm = None
        for activation, vertices in self._world.states(q):
            self._world.activation = activation
            meant_mm = self._world.balance(meant_q, vertices if meant_mm is None else meant_mm)
            if rigid_distance_mm(vertices, meant_mm) > PARTED_MM:
                logger.info("parts from the design at an activation of %.3f", activation)
                self._parted = activation
                return

    def begin(self, design: Design) -> np.ndarray:
        """Find the place on a design's ramp that counts; returns its film there [mm], shape [n, 3].

        Raises:
            SolverError: if the film cannot be heated from flat.
        """
        begun, world = self._begun, self._world
        if begun is not None and begun.design is design and begun.parted == self._parted:
            world.activation = begun.activation
            return begun.vertices_mm
        self._begun, q = None, design.q
        states = world.states(q)
        self.end_mm = states[-1][1]
        vertices = self._softest(q, states) if self._parted is None else self._at_parting(q, states, self._parted)
        self._wanted_mm = np.zeros_like(vertices)
        self._wanted_mm[:, 2] = world.activation / self._hot * design.shape.vertices_mm[:, 2]
        if not world.linearise(q, vertices):
            raise SolverError("on the way up: the equilibrium is not stable.")
        self._loss = ExpectedLoss(world, self._errors, self._cost, q, ways=WAYS)
        self._begun = _Begun(design, self._parted, world.activation, vertices)
        return vertices

    def _at_parting(self, q: np.ndarray, states: Sequence[State], activation: float) -> np.ndarray:
        """Return the film at an activation, from the state of its ramp before."""
        before = [vertices for at, vertices in states if at <= activation]
        self._world.activation = activation
        return self._world.balance(q, before[-1])

    def _softest(self, q: np.ndarray, states: Sequence[State]) -> np.ndarray:
        """Go to where noise moves the film farthest, to first order."""
        world = self._world
        examples, found = np.stack(self._errors.examples(q)), []
        for activation, near_mm in states:
            if not FIRST * self._hot <= activation <= LAST * self._hot:
                continue
            world.activation = activation
            vertices = world.balance(q, near_mm)
            if world.linearise(q, vertices):
                variance = sum(self._cost.flattened(move[:, 2]) ** 2 for move in world.push(examples))
                found.append((float(np.sqrt(np.max(variance))), activation, vertices))
        if not found:
            raise SolverError("on the way up: no stable equilibrium.")
        deviation_mm, world.activation, vertices = max(found, key=lambda each: each[0])
        logger.info("softest on the way at an activation of %.3f: %.3f mm", world.activation, deviation_mm)
        return vertices

    def at(self, q: np.ndarray, near_mm: np.ndarray) -> np.ndarray:
        """Work out what an alignment [layers, m, 2] pays; returns its film there, near another [mm], shape [n, 3].

        Raises:
            SolverError: if there is no equilibrium, or none that is stable.
        """
        vertices = self._world.balance(q, near_mm)
        if not self._world.linearise(q, vertices):
            raise SolverError("on the way up: the equilibrium is not stable.")
        self._loss.at(q, vertices)
        off = vertices - self._wanted_mm
        self._by_vertices = self._cost.curve(off)
        self.value = 0.5 * float((off * self._by_vertices).sum()) + NOISE_WEIGHT * self._loss.value
        return vertices

    def gradient(self) -> np.ndarray:
        """Return the gradient by the alignment, shape [layers, m, 2]."""
        by_q, by_vertices = (NOISE_WEIGHT * part for part in self._loss.gradient())
        return by_q + self._world.pull(self._by_vertices + by_vertices)

    def push(self, dq: np.ndarray) -> np.ndarray:
        """Return how the vertices move [mm], shape [n, 3], for a change of the alignment."""
        return self._world.push(dq)

    def close(self) -> None:
        """Release the solver's memory."""
        self._world.newton.close()


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
