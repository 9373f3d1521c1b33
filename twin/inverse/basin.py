"""Keep a design in the basin of its target: the ramp from the flat film must end in the shape that was designed."""

import logging
from collections.abc import Callable, Sequence

import numpy as np
from scipy.spatial import KDTree

from planner.errors import SolverError
from twin.equilibrium import moved_onto, rigid_distance_mm
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
LEAVING_COSTS = 0.1
"""Added to a design's price if all films leave it: for the choice among a search's designs."""
RAMPS_AFTER = 0.6
"""Share of a round that is over when its films are heated."""
LEAVING_SHARE = 0.6
"""A film that has left did so where it is off by more than this share of the most."""
HELD, HELD_LENGTH_MM = 4.0, 3.0
"""Factor on the anchor where a film has left, and how far around."""
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

    Where a noisy film ends in another shape, the anchor gets more weight there; where the design's own film does, the
    next round starts from the best of the steps before. After a round without, the whole anchor gets less. Of the
    designs that keep their shape the cheapest counts, films that leave it added; without any it is the first.

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
    film = world.newton.shell.film
    centre_mm = film.flat_mm[film.triangles].mean(axis=1)
    best: tuple[float, Design] | None = None
    for number in range(rounds):
        try:
            way = hardening.harden(
                design, evaluations, lambda share, before=number: progress((before + RAMPS_AFTER * share) / rounds)
            )
            landed = _landed(world, way)
            lost = landed < len(way) - 1
            if lost:
                hardening.left_by(way[landed + 1].q, way[landed].q)
            steps = sorted({landed * part // PARTS for part in range(PARTS + 1)}) if lost else [landed]
            found = {step: hardening.measured(way[step], design) for step in steps if step > 0}
            prices = {step: hardening.price(each) for step, each in found.items()}
            # a step between those that were heated need not land
            landed = min((step for step in prices if np.isfinite(prices[step])), key=prices.__getitem__, default=0)
            design = found.get(landed, design)
            films = [] if lost else hardening.noisy(design, number)
            left = [_left_mm(world, design.q, design.shape.vertices_mm, q) for q in films]
        except SolverError as error:
            logger.info("hardening: %s", error)
            break
        more = go_on(design)
        leaving = [off_mm[film.triangles].mean(axis=1) for off_mm in left if off_mm.max() > LEFT_MM]
        logger.info(
            "goes on from step %d of %d, %d of %d films leave it", landed, len(way) - 1, len(leaving), len(left)
        )
        if landed > 0:
            cost = prices[landed] + LEAVING_COSTS * (1.0 if lost else len(leaving) / len(left))
            if best is None or cost <= best[0]:
                best = cost, design
        if leaving:
            hardening.left_by(films[int(np.argmax([off_mm.max() for off_mm in left]))], design.q)
            there = centre_mm[np.any([off_mm >= LEAVING_SHARE * off_mm.max() for off_mm in leaving], axis=0)]
            near = np.exp(-((KDTree(there).query(centre_mm)[0] / HELD_LENGTH_MM) ** 2))
            refinement.anchor.hold = refinement.anchor.hold * (1.0 + (HELD - 1.0) * near)
        elif not lost:
            refinement.weight_per_mm3 = max(refinement.weight_per_mm3 / FACTOR, WEIGHTS_PER_MM3[-1])
        elif landed == 0:
            refinement.weight_per_mm3 = min(FACTOR * refinement.weight_per_mm3, STRONGEST_PER_MM3)
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
        if _left_mm(world, way[trial].q, way[trial].vertices_mm, way[trial].q).max() > LEFT_MM:
            high = trial
        else:
            low = trial
        trial = (low + high) // 2
    return low


def _left_mm(world: World, meant_q: np.ndarray, meant_mm: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return how far each vertex of a film ends from where the answer of the one meant puts it, shape [n].

    Infinitely far where the film cannot be heated.
    """
    try:
        if not world.linearise(meant_q, meant_mm):
            raise SolverError("the design's equilibrium is not stable.")
        meant = meant_mm + world.push(q - meant_q)
        return np.linalg.norm(moved_onto(world.ramp(q), meant) - meant, axis=1)
    except SolverError as error:
        logger.info("a film beside the design: %s", error)
        return np.full(len(meant_mm), np.inf)
