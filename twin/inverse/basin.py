"""Keep a design in the basin of its target: the ramp from the flat film must end in the shape that was designed."""

import logging
from collections.abc import Callable, Sequence

import numpy as np

from planner.errors import SolverError
from twin.equilibrium import rigid_distance_mm
from twin.inverse.harden import LEFT_MM, Hardening, Point
from twin.inverse.refine import Design, Refinement
from twin.inverse.world import World

logger = logging.getLogger(__name__)

SAME_MM = 0.1
"""A designed shape and the ramp's are the same if no vertex is farther off, rigid motion aside."""
WEIGHTS_PER_MM3 = (1e-2, 3e-3, 1e-3)
"""Weights of the anchor, from the one that holds nearly every film in the basin of its target downwards."""
FACTOR = 3.0
STRONGEST_PER_MM3 = 0.05
WEAKEST_PER_MM3 = 3e-4
"""Least weight of the anchor in hardening, where the way up the ramp holds a film as well."""
ROUND_SETTLED = 0.02
"""Relative gain of one round of hardening below which its design has settled."""
TESTED_EVERY = 2
"""Rounds after which noisy films are heated, settled or not."""
RAMPS_AFTER = 0.6
"""Share of a round that is over when its films are heated."""
INSISTENCE = 2.0
"""Factor on what the way up the ramp costs, after a test that is worse than the best."""
PARTS = 4
"""Of the steps that land, those that are compared where a later one does not: the last ones stand near a snap."""
FAILURES = 4
"""Ramps that may end elsewhere before a search is given up."""
SETTLED = 0.003
"""Relative gain of one step below which a design has settled."""


def descend(refinement: Refinement, design: Design, *, steps: int, go_on: Callable[[Design], bool]) -> Design:
    """Take steps until they no longer pay.

    Args:
        refinement: what is minimised.
        design: where to start.
        steps: at most so many.
        go_on: called with each new design; False ends the descent.
    """
    for _ in range(steps):
        better = refinement.step(design)
        if better is None:
            break
        gain, design = 1.0 - better.value / design.value, better
        if not go_on(design) or gain < SETTLED:
            break
    return design


def ramped(refinement: Refinement, world: World, design: Design) -> tuple[Design, bool]:
    """Return the design with the shape that its film takes when heated from flat, and whether that was its shape.

    Raises:
        SolverError: if the film cannot be heated.
    """
    found = world.settle(design.q, world.ramp(design.q), design.shape)
    off = rigid_distance_mm(found.vertices_mm, design.shape.vertices_mm)
    logger.info("ramp from flat: %.3f mm off, ssim %.4f", off, found.measured.ssim)
    if off < SAME_MM:
        return design, True
    return refinement.valued(design.p, design.q, found), False


def descend_in_basin(
    refinement: Refinement,
    world: World,
    design: Design,
    *,
    weights_per_mm3: Sequence[float],
    steps: int,
    go_on: Callable[[Design], bool],
) -> Design:
    """Descend under ever less weight of the anchor, as long as the ramp from flat ends in the design's shape.

    Where it ends elsewhere, the descent goes on from there under more weight. Returned is the design that the ramp
    brings nearest to the target, with the ramp's shape; the refinement is left with its weight.

    Args:
        refinement: what is minimised.
        world: the film.
        design: where to start.
        weights_per_mm3: weights of the anchor, descending.
        steps: at most so many for each weight.
        go_on: called with each new design; False ends the search.
    """
    more, failures, waiting = True, 0, list(weights_per_mm3)
    best: tuple[Design, float] | None = None

    def watched(candidate: Design) -> bool:
        nonlocal more
        more = go_on(candidate)
        return more

    while waiting and failures < FAILURES:
        weight = waiting.pop(0)
        candidate = descend(refinement, refinement.weighed(design, weight), steps=steps, go_on=watched)
        try:
            design, landed = ramped(refinement, world, candidate)
        except SolverError as error:
            logger.info("ramp: %s", error)
            break
        if best is None or design.shape.measured.value < best[0].shape.measured.value:
            best = design, weight
        if not landed:
            failures += 1
            waiting = [min(FACTOR * weight, STRONGEST_PER_MM3)]
        elif failures or not more:
            break
    if best is None:
        return design
    refinement.weight_per_mm3 = best[1]
    return best[0]


def harden_in_basin(
    refinement: Refinement,
    hardening: Hardening,
    world: World,
    design: Design,
    *,
    rounds: int,
    evaluations: int,
    go_on: Callable[[Design], bool],
    progress: Callable[[float], None],
) -> Design:
    """Harden a design in rounds, so that it and noisy films keep its shape when heated from flat.

    Noisy films are heated every few rounds, and where a design has settled: what these really lose is the test that the
    expected loss cannot be, being of second order. A design that they prefer is kept, and the anchor gets less. From
    one that they do not the search goes back to the best before, with more weight on the anchor and on the way up the
    ramp. Where the design's own film leaves its shape the next round starts from the best of the steps before.

    Args:
        refinement: the design's, with the anchor that hardening uses as well.
        hardening: what hardens.
        world: the film.
        design: where to start: one that keeps its shape.
        rounds: at most so many.
        evaluations: equilibria in each round, about.
        go_on: called with each new design; False ends the search.
        progress: called with the share done, 0 to 1.
    """
    best: tuple[float, Design] | None = None
    for number in range(rounds):
        try:
            way = hardening.harden(
                design, evaluations, lambda share, before=number: progress((before + RAMPS_AFTER * share) / rounds)
            )
            landed = len(way) - 1
            reached = hardening.measured(way[landed], design) if landed > 0 else design
            price = hardening.price(reached)
            lost = landed > 0 and np.isinf(price)
            if lost:
                last, found = _landed(world, way), []
                for step in sorted({last * part // PARTS for part in range(1, PARTS + 1)} - {0}):
                    trial = hardening.measured(way[step], design)
                    found.append((hardening.price(trial), step, trial))
                # a step between those that were heated need not land
                landing = [each for each in found if np.isfinite(each[0])]
                price, landed, reached = min(landing, key=lambda each: each[0], default=(price, 0, design))
            design = reached
            settled = not lost and way[-1].value > (1.0 - ROUND_SETTLED) * way[0].value
            tested = settled or number % TESTED_EVERY == TESTED_EVERY - 1 or number == rounds - 1
            losses = [_dissimilarity(world, design, q) for q in hardening.noisy(design)] if tested else []
        except SolverError as error:
            logger.info("hardening: %s", error)
            break
        more = go_on(design)
        logger.info("goes on from step %d of %d", landed, len(way) - 1)
        worse = False
        if tested:
            loss = float(np.mean(losses))
            worse = best is not None and loss > best[0]
            logger.info("noisy films lose %.4f, the best design's %.4f", loss, loss if best is None else best[0])
            if best is None or not worse:
                best = loss, design
            else:
                design = best[1]
                refinement.way_weight *= INSISTENCE
        if worse or (lost and landed == 0):
            refinement.weight_per_mm3 = min(FACTOR * refinement.weight_per_mm3, STRONGEST_PER_MM3)
        elif settled and refinement.weight_per_mm3 <= WEAKEST_PER_MM3:
            break
        elif tested:
            refinement.weight_per_mm3 = max(refinement.weight_per_mm3 / FACTOR, WEAKEST_PER_MM3)
        if not more:
            break
    return design if best is None else best[1]


def _landed(world: World, way: Sequence[Point]) -> int:
    """Return the last step of a way whose film keeps its shape.

    The first step is taken to land. Steps between one that lands and one that does not are halved, no more: a film that
    comes back to its shape farther on is as good.
    """
    low, high = 0, len(way)
    trial = high - 1
    while high - low > 1:
        if _left(world, way[trial]):
            high = trial
        else:
            low = trial
        trial = (low + high) // 2
    return low


def _left(world: World, point: Point) -> bool:
    """Return whether a film ends in another shape than its own when heated from flat, or cannot be heated."""
    try:
        return rigid_distance_mm(world.ramp(point.q), point.vertices_mm) > LEFT_MM
    except SolverError as error:
        logger.info("a step's film: %s", error)
        return True


def _dissimilarity(world: World, design: Design, q: np.ndarray) -> float:
    """Return 1 - Eq. 4 of a film beside a design, heated from flat; 1 where it cannot be."""
    try:
        return 1.0 - world.settle(q, world.ramp(q), design.shape).measured.ssim
    except SolverError as error:
        logger.info("a film beside the design: %s", error)
        return 1.0
