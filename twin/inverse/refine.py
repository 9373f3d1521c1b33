"""Refine a design through its equilibrium: Gauss-Newton steps with adjoints.

Minimised is, over the design variables p,

    mismatch + weight T(q(p)) + penalty(p),

where T is the energy of `twin.inverse.anchor`: little of it keeps the ramp from flat on its way to the target.
"""

import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from planner.errors import SolverError
from twin.inverse.anchor import Anchor
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
    """Alignment of the triangles, shape [layers, m, 2]."""
    shape: Shape
    value: float
    """What is minimised."""


class Refinement:
    """Minimises over the design variables; every trial is an equilibrium."""

    def __init__(self, world: World, control: Control, anchor: Anchor, *, weight_per_mm3: float) -> None:
        """Prepare.

        Args:
            world: the film.
            control: the design variables.
            anchor: what ties the design to the target beside its shape.
            weight_per_mm3: the anchor's weight.
        """
        self._world, self._control, self.anchor = world, control, anchor
        self.weight_per_mm3 = weight_per_mm3
        self._damping = 1.0

    def design(self, p: np.ndarray, start_mm: np.ndarray, near: Shape | None = None) -> Design:
        """Find and measure the equilibrium of p near a start [mm], shape [n, 3].

        Raises:
            SolverError: if there is none.
        """
        q = self._control.q(p)
        return self.valued(p, q, self._world.settle(q, start_mm, near))

    def valued(self, p: np.ndarray, q: np.ndarray, shape: Shape) -> Design:
        """Return a design with what is minimised."""
        held = self.weight_per_mm3 * self.anchor.value(q)[0] + self._control.penalty(p)[0]
        return Design(p=p, q=q, shape=shape, value=shape.measured.value + held)

    def weighed(self, design: Design, weight_per_mm3: float) -> Design:
        """Return the same design under another weight of the anchor, which holds from then on."""
        self.weight_per_mm3, self._damping = weight_per_mm3, 1.0
        return self.valued(design.p, design.q, design.shape)

    def step(self, design: Design) -> Design | None:
        """Return a better design, or None if no damping gives one.

        Raises:
            SolverError: if the design's own equilibrium is not stable.
        """
        control, world, p, shape = self._control, self._world, design.p, design.shape
        self._linearise(design)
        by_anchor = self.weight_per_mm3 * self.anchor.value(design.q)[1]
        gradient = control.pull(p, world.pull(shape.measured.gradient) + by_anchor) + control.penalty(p)[1]

        def model(dp: np.ndarray, damping: float) -> np.ndarray:
            dq = control.push(p, dp)
            move = world.push(dq)
            # soft bending modes move far for little: they are what the linear model is wrong about
            held = damping * MOVE_DAMPING_PER_MM2 * world.vertex_share * move
            curved = world.pull(shape.measured.curve(move) + held) + self.weight_per_mm3 * self.anchor.curve(dq)
            return control.pull(p, curved) + control.penalty_curve(p, dp)

        for trial_number in range(TRIALS):
            if trial_number:
                self._linearise(design)
            damping = self._damping * control.damping
            dp = _conjugate_gradients(
                lambda d, own=self._damping, c=damping: model(d, own) + c * d, -gradient, control.precondition
            )
            move = world.push(control.push(p, dp))
            longest = float(np.linalg.norm(move, axis=1).max())
            part = min(1.0, LONGEST_STEP_MM / max(longest, 1e-12))
            expected = -part * float((gradient * dp).sum()) - 0.5 * part**2 * float((dp * model(dp, 0.0)).sum())
            try:
                trial = self.design(p + part * dp, shape.vertices_mm + part * move, shape)
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
        self.anchor.linearise(design.q)
        if not self._world.linearise(design.q, design.shape.vertices_mm):
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
