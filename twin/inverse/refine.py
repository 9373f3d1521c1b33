"""Refine a design through its equilibria: Gauss-Newton steps with adjoints.

Minimised is, over the design variables p,

    mean over the films of the mismatch + weight T(q(p)) + penalty(p),

where T is the energy of `twin.inverse.anchor`: little of it keeps the ramp from flat on its way to the target.
"""

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from planner.errors import SolverError
from twin.inverse.anchor import Anchor
from twin.inverse.distortion import Distortion
from twin.inverse.noise import NoiseModes
from twin.inverse.world import Shape, World

logger = logging.getLogger(__name__)

LONGEST_STEP_MM = 3.0
TRIALS = 4
MOVE_DAMPING_PER_MM2 = 0.1
"""Unit of the damping of the vertices' mean square displacement."""
INNER_STEPS = 40
INNER_ACCURACY = 0.05


class Control(Protocol):
    """Design variables p of any shape, and how the triangles' alignment follows from them."""

    damping: float
    """Unit of the steps' damping."""

    def q(self, p: np.ndarray, /) -> np.ndarray:
        """Return the alignment vectors, shape [layers, m, 2]."""
        ...

    def push(self, p: np.ndarray, dp: np.ndarray, /) -> np.ndarray:
        """Return their change for a change of p."""
        ...

    def pull(self, p: np.ndarray, by_q: np.ndarray, /) -> np.ndarray:
        """Return the gradient by p from that by q."""
        ...

    def penalty(self, p: np.ndarray, /) -> tuple[float, np.ndarray]:
        """Return the penalty and its gradient."""
        ...

    def penalty_curve(self, p: np.ndarray, dp: np.ndarray, /) -> np.ndarray:
        """Return a positive semi-definite curvature of the penalty times dp."""
        ...

    def precondition(self, gradient: np.ndarray, /) -> np.ndarray:
        """Return an approximate inverse of penalty and damping times a gradient."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class Design:
    """Design variables and what becomes of them."""

    p: np.ndarray
    q: np.ndarray
    """Intended alignment of the triangles, shape [layers, m, 2]."""
    shapes: tuple[Shape, ...]
    """One a world; the first is the nominal film."""
    value: float
    """What is minimised."""

    @property
    def nominal(self) -> Shape:
        """The film as intended."""
        return self.shapes[0]


class Refinement:
    """Minimises over the design variables; every trial is an equilibrium in every world."""

    def __init__(
        self,
        worlds: Sequence[World],
        control: Control,
        anchor: Anchor,
        *,
        weight_per_mm3: float,
        noise: NoiseModes | None = None,
    ) -> None:
        """Prepare.

        Args:
            worlds: the nominal film, then those that noise distorts, all of one mesh.
            control: the design variables.
            anchor: what ties the design to the target beside its shape.
            weight_per_mm3: the anchor's weight.
            noise: what distorts the other films.
        """
        self._worlds, self._control, self._anchor, self._noise = tuple(worlds), control, anchor, noise
        self.weight_per_mm3 = weight_per_mm3
        self._damping = 1.0

    def design(self, p: np.ndarray, starts_mm: Sequence[np.ndarray], near: Design | None = None) -> Design:
        """Find and measure the equilibria of p near starts [mm], shape [n, 3], one a world (or one for all).

        Raises:
            SolverError: if one has none.
        """
        q = self._control.q(p)
        starts = [*starts_mm, *[starts_mm[-1]] * (len(self._worlds) - len(starts_mm))]
        before = [None] * len(self._worlds) if near is None else near.shapes
        shapes = tuple(
            world.settle(q, start, shape) for world, start, shape in zip(self._worlds, starts, before, strict=True)
        )
        return Design(p=p, q=q, shapes=shapes, value=self.value(p, q, shapes))

    def value(self, p: np.ndarray, q: np.ndarray, shapes: Sequence[Shape]) -> float:
        """Return what is minimised."""
        mismatch = float(np.mean([shape.measured.value for shape in shapes]))
        return mismatch + self.weight_per_mm3 * self._anchor.value(q)[0] + self._control.penalty(p)[0]

    def weighed(self, design: Design, weight_per_mm3: float) -> Design:
        """Return the same design under another weight of the anchor, which holds from then on."""
        self.weight_per_mm3, self._damping = weight_per_mm3, 1.0
        return replace(design, value=self.value(design.p, design.q, design.shapes))

    def renewed(self, design: Design) -> Design:
        """Return the same design with the noisy films that it now suffers most from; without noise, as it is.

        Where one of these has no equilibrium, the former ones stay.

        Raises:
            SolverError: if the design's equilibrium is not stable.
        """
        if self._noise is None:
            return design
        nominal = self._worlds[0]
        self._linearised(nominal, design.q, design.nominal)
        former = [world.distortion for world in self._worlds[1:]]
        self._distort(self._noise.worst(nominal, design.q, design.nominal))
        try:
            return self.design(design.p, [design.nominal.vertices_mm], design)
        except SolverError as error:
            logger.info("a film under the worst errors: %s", error)
            self._distort(former)
            return design

    def _distort(self, distortions: Sequence[Distortion | None]) -> None:
        for world, distortion in zip(self._worlds[1:], distortions, strict=True):
            world.distortion = distortion

    def step(self, design: Design) -> Design | None:
        """Return a better design, or None if no damping gives one.

        Raises:
            SolverError: if the design's own equilibria are not stable.
        """
        control, worlds, p = self._control, self._worlds, design.p
        share = 1.0 / len(worlds)
        self._linearise(design)
        by_q = sum(
            world.pull(share * shape.measured.gradient) for world, shape in zip(worlds, design.shapes, strict=True)
        )
        by_anchor = self.weight_per_mm3 * self._anchor.value(design.q)[1]
        gradient = control.pull(p, by_q + by_anchor) + control.penalty(p)[1]

        def model(dp: np.ndarray, damping: float) -> np.ndarray:
            dq = control.push(p, dp)
            curved = np.zeros_like(dq)
            for world, shape in zip(worlds, design.shapes, strict=True):
                move = world.push(dq)
                # soft bending modes move far for little: they are what the linear model is wrong about
                held = damping * MOVE_DAMPING_PER_MM2 * world.vertex_share * move
                curved += world.pull(share * (shape.measured.curve(move) + held))
            return control.pull(p, curved + self.weight_per_mm3 * self._anchor.curve(dq)) + control.penalty_curve(p, dp)

        for trial_number in range(TRIALS):
            if trial_number:
                self._linearise(design)
            damping = self._damping * control.damping
            dp = _conjugate_gradients(
                lambda d, own=self._damping, c=damping: model(d, own) + c * d, -gradient, control.precondition
            )
            dq = control.push(p, dp)
            moves = [world.push(dq) for world in worlds]
            longest = max(float(np.linalg.norm(move, axis=1).max()) for move in moves)
            part = min(1.0, LONGEST_STEP_MM / max(longest, 1e-12))
            expected = -part * float((gradient * dp).sum()) - 0.5 * part**2 * float((dp * model(dp, 0.0)).sum())
            starts = [shape.vertices_mm + part * move for shape, move in zip(design.shapes, moves, strict=True)]
            try:
                trial = self.design(p + part * dp, starts, design)
            except SolverError as error:
                logger.info("trial: %s", error)
                self._damping *= 8.0
                continue
            gain = (design.value - trial.value) / max(expected, 1e-300)
            logger.info("damping %.1e, moved %.2f mm, gain ratio %.2f", self._damping, longest, gain)
            if gain > 0.0:
                if gain > 0.6 and part == 1.0 and not trial_number:
                    self._damping = max(self._damping / 4.0, 1e-6)
                elif gain < 0.25:
                    self._damping *= 3.0
                return trial
            self._damping *= 8.0
        return None

    def _linearise(self, design: Design) -> None:
        self._anchor.linearise(design.q)
        for world, shape in zip(self._worlds, design.shapes, strict=True):
            self._linearised(world, design.q, shape)

    def _linearised(self, world: World, q: np.ndarray, shape: Shape) -> None:
        if not world.linearise(q, shape):
            raise SolverError("refinement: the design's equilibrium is not stable; start from another seed.")


def _conjugate_gradients(
    apply: Callable[[np.ndarray], np.ndarray], right: np.ndarray, precondition: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    """Solve a positive definite system roughly: early steps find what matters, an early end regularises."""
    x = np.zeros_like(right)
    residual = right.copy()
    z = precondition(residual)
    direction, size = z.copy(), float((residual * z).sum())
    enough = INNER_ACCURACY**2 * size
    for _ in range(INNER_STEPS):
        image = apply(direction)
        length = size / float((direction * image).sum())
        x += length * direction
        residual -= length * image
        z = precondition(residual)
        size, previous = float((residual * z).sum()), size
        if size <= enough:
            break
        direction = z + size / previous * direction
    return x
