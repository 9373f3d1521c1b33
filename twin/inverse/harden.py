"""Make a design less sensitive to the noise of the process, keeping its shape: L-BFGS on a smooth model.

Minimised is, over the design variables p,

    mismatch(x) + NOISE_WEIGHT L(q) + P(q) + weight T(q) + penalty(p),

with the expected loss L of `twin.inverse.expected_loss`, the anchor's T, and P of `twin.inverse.on_the_way`. The
mismatch is its quadratic model at the design that one starts from: counting pixels and windows anew at each step would
make it too rough for differences of gradients, which is what L-BFGS lives on. Gauss-Newton steps do not help here: how
much noise moves a film is decided by how stiff it is, and that is just what they leave out of the curvature.

Nocedal and Wright, Numerical Optimization (2006), algorithm 7.4 and 3.1.
"""

import logging
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from planner.errors import SolverError
from twin.equilibrium import rigid_distance_mm
from twin.inverse.expected_loss import NOISE_HEIGHTS, NOISE_OUTLINE, NOISE_WEIGHT, ExpectedLoss
from twin.inverse.noise import ProcessErrors
from twin.inverse.on_the_way import OnTheWay
from twin.inverse.refine import Control, Design, Refinement
from twin.inverse.world import World

logger = logging.getLogger(__name__)

HEIGHTS, OUTLINE = 0.3, 2.0
"""Factors on the mismatch's rms^2 and outline^2/2 for the film as intended: windows see its rim before its heights."""
WORST_DEVIATIONS, DRAWN = 2.0, 4
"""Standard deviations of the mix of errors that costs most, and number of random films, for the ramps."""
LEFT_MM = 2.0
"""A film has left the design's shape if its ramp ends farther from where the answer to its errors, to first order,
puts it: it has snapped, or is much softer than the expected loss knows."""
PAIRS = 20
"""Steps whose change of the gradient is remembered."""
FIRST_MOVE_MM, LONGEST_MOVE_MM = 0.1, 1.0
TRIALS = 6
SHORTER = 0.35
ENOUGH = 1e-4
"""Share of the slope that a step must gain."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Point:
    """A step of a descent: a design whose film has not been measured."""

    p: np.ndarray
    q: np.ndarray
    """Alignment of the triangles, shape [layers, m, 2]."""
    vertices_mm: np.ndarray
    """Its equilibrium [mm], shape [n, 3]."""
    way_mm: np.ndarray
    """The same on its way up the ramp."""
    value: float
    loss: float
    on_the_way: float
    by_anchor: np.ndarray
    """Gradient of the anchor's energy by q."""


class Hardening:
    """Descends from one design after the other."""

    def __init__(
        self, refinement: Refinement, world: World, control: Control, errors: ProcessErrors, on_the_way: OnTheWay
    ) -> None:
        """Prepare.

        Args:
            refinement: of the same film and variables, with the anchor and its weight.
            world: the film.
            control: the design variables.
            errors: of the process.
            on_the_way: the film on its way up the ramp.
        """
        self._refinement, self._world, self._control, self._errors = refinement, world, control, errors
        self._on_the_way = on_the_way
        self._begun: tuple[Design, ExpectedLoss] | None = None

    def harden(self, design: Design, evaluations: int, progress: Callable[[float], None]) -> list[Point]:
        """Return points of ever less value, from the design on, after about so many evaluations.

        Args:
            design: where to start.
            evaluations: equilibria to find at most.
            progress: called with the share of them that were found.

        Raises:
            SolverError: if the design's own equilibrium is not stable, at the end of its ramp or on the way up.
        """
        on_the_way = self._on_the_way
        model, start = design.shape.measured.model, design.shape.vertices_mm
        intended = model.weighed(heights=HEIGHTS, outline=OUTLINE)
        loss = self._loss(design)
        anchor, weight = self._refinement.anchor, self._refinement.weight_per_mm3
        slope_there = intended.gradient()

        def point(p: np.ndarray, near_mm: np.ndarray, way_near_mm: np.ndarray) -> Point:
            q = self._control.q(p)
            vertices = self._world.balance(q, near_mm)
            self._linearise(q, vertices)
            loss.at(q, vertices)
            way_mm = on_the_way.at(q, way_near_mm)
            moved = vertices - start
            mismatch = float((moved * (slope_there + 0.5 * intended.curve(moved))).sum())
            energy, by_anchor = anchor.value(q)
            held = weight * energy + self._control.penalty(p)[0]
            return Point(
                p=p,
                q=q,
                vertices_mm=vertices,
                way_mm=way_mm,
                value=mismatch + NOISE_WEIGHT * loss.value + on_the_way.value + held,
                loss=loss.value,
                on_the_way=on_the_way.value,
                by_anchor=by_anchor,
            )

        def gradient(here: Point) -> np.ndarray:
            """Of the point that was evaluated last."""
            by_q, by_vertices = (NOISE_WEIGHT * part for part in loss.gradient())
            by_vertices += slope_there + intended.curve(here.vertices_mm - start)
            by_q += self._world.pull(by_vertices) + on_the_way.gradient() + weight * here.by_anchor
            return self._control.pull(here.p, by_q) + self._control.penalty(here.p)[1]

        here = point(design.p, start, on_the_way.begin(design))
        way, slope = [here], gradient(here)
        pairs: deque[tuple[np.ndarray, np.ndarray]] = deque(maxlen=PAIRS)
        left = evaluations
        while left > 0:
            direction = -self._inverse_curvature(slope, pairs)
            turn = self._control.push(here.p, direction)
            move, way_move = self._world.push(turn), on_the_way.push(turn)
            longest = max(float(np.linalg.norm(each, axis=1).max()) for each in (move, way_move))
            length = min(1.0, (LONGEST_MOVE_MM if pairs else FIRST_MOVE_MM) / max(longest, 1e-300))
            for _ in range(TRIALS):
                left -= 1
                progress(1.0 - max(left, 0) / evaluations)
                try:
                    trial = point(
                        here.p + length * direction, here.vertices_mm + length * move, here.way_mm + length * way_move
                    )
                    if trial.value < here.value + ENOUGH * length * float((slope * direction).sum()):
                        break
                except SolverError as error:
                    logger.info("trial: %s", error)
                length *= SHORTER
            else:
                break
            there = gradient(trial)
            pair = trial.p - here.p, there - slope
            if float((pair[0] * pair[1]).sum()) > 0.0:
                pairs.append(pair)
            here, slope = trial, there
            way.append(here)
        first = way[0]
        logger.info(
            "hardened: %.4f to %.4f, expected loss %.4f to %.4f, on the way %.4f to %.4f",
            *(first.value, here.value, first.loss, here.loss, first.on_the_way, here.on_the_way),
        )
        return way

    def measured(self, point: Point, near: Design) -> Design:
        """Return the design of a point, its film registered as that of a design near it at first."""
        return self._refinement.design(point.p, point.vertices_mm, near.shape)

    def price(self, design: Design) -> float:
        """Return what a design costs with noise: dissimilarity, expected loss, and what its way up the ramp does.

        Infinity where its film cannot be heated from flat, is not stable, or ends in another shape.
        """
        on_the_way = self._on_the_way
        try:
            loss = self._loss(design)
            loss.at(design.q, design.shape.vertices_mm)
            on_the_way.at(design.q, on_the_way.begin(design))
        except SolverError as error:
            logger.info("price: %s", error)
            return float("inf")
        off_mm = rigid_distance_mm(on_the_way.end_mm, design.shape.vertices_mm)
        if off_mm > LEFT_MM:
            logger.info("price: the ramp ends %.1f mm off", off_mm)
            return float("inf")
        ssim = design.shape.measured.ssim
        logger.info("ssim %.4f, expected loss %.4f, on the way %.4f", ssim, loss.value, on_the_way.value)
        return 1.0 - ssim + NOISE_WEIGHT * loss.value + on_the_way.value

    def left_by(self, q: np.ndarray, meant_q: np.ndarray) -> None:
        """Keep designs from where a film of alignment q parts, on its way up, from that which it should stay beside."""
        try:
            self._on_the_way.left_by(q, meant_q)
        except SolverError as error:
            logger.info("a film that left: %s", error)

    def noisy(self, design: Design, number: int) -> list[np.ndarray]:
        """Return the alignment of films beside a design that should keep its shape, other ones for each number.

        They are films under the mix of errors that costs most, to both sides, and random ones.
        """
        worst = WORST_DEVIATIONS * self._loss(design).worst
        drawn = self._errors.draw(self._world.film(design.q), DRAWN, number)
        return [design.q + worst, design.q - worst, *drawn]

    def _loss(self, design: Design) -> ExpectedLoss:
        """Linearise at a design; return the loss in its soft ways, which are looked for once for each design."""
        self._linearise(design.q, design.shape.vertices_mm)
        if self._begun is None or self._begun[0] is not design:
            cost = design.shape.measured.model.weighed(heights=NOISE_HEIGHTS, outline=NOISE_OUTLINE)
            self._begun = design, ExpectedLoss(self._world, self._errors, cost, design.q)
        return self._begun[1]

    def _inverse_curvature(self, gradient: np.ndarray, pairs: deque[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
        """Return the approximate inverse of the curvature times a gradient: the two loops of L-BFGS."""
        rest, shares = gradient.copy(), []
        for step, change in reversed(pairs):
            share = float((step * rest).sum() / (step * change).sum())
            rest = rest - share * change
            shares.append(share)
        scale = 1.0
        if pairs:
            step, change = pairs[-1]
            scale = float((step * change).sum() / (change * self._control.precondition(change)).sum())
        found = scale * self._control.precondition(rest)
        for (step, change), share in zip(pairs, reversed(shares), strict=True):
            found = found + step * (share - float((change * found).sum() / (step * change).sum()))
        return found

    def _linearise(self, q: np.ndarray, vertices_mm: np.ndarray) -> None:
        if not self._world.linearise(q, vertices_mm):
            raise SolverError("hardening: the equilibrium is not stable.")
