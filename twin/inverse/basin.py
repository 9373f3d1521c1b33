"""Keep a design in the basin of its target: the ramp from the flat film must end in the shape that was designed."""

import logging
from collections.abc import Callable, Sequence

from planner.errors import SolverError
from twin.equilibrium import rigid_distance_mm
from twin.inverse.refine import Design, Refinement
from twin.inverse.world import World

logger = logging.getLogger(__name__)

SAME_MM = 0.1
"""A designed shape and the ramp's are the same if no vertex is farther off, rigid motion aside."""
WEIGHTS_PER_MM3 = (1e-2, 3e-3, 1e-3)
"""Weights of the anchor, from the one that holds nearly every film in the basin of its target downwards."""
STRONGEST_PER_MM3 = 0.05
"""From this weight on a failure is final."""
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


def lands_there(world: World, design: Design) -> bool:
    """Tell whether the nominal film of a design, heated from flat, ends in the shape that was designed."""
    try:
        found = world.settle(design.q, world.ramp(design.q), design.nominal)
    except SolverError as error:
        logger.info("ramp: %s", error)
        return False
    off = rigid_distance_mm(found.vertices_mm, design.nominal.vertices_mm)
    logger.info("ramp from flat: %.3f mm off, ssim %.4f", off, found.measured.ssim)
    return off < SAME_MM


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

    The refinement is left with the weight of the design that is returned.

    Args:
        refinement: what is minimised.
        world: the nominal film.
        design: a design whose shape is where the ramp ends.
        weights_per_mm3: weights of the anchor, descending; where the first fails, larger ones are tried.
        steps: at most so many for each weight.
        go_on: called with each new design; False ends the search.
    """
    more = True

    def watched(candidate: Design) -> bool:
        nonlocal more
        more = go_on(candidate)
        return more

    good: float | None = None
    waiting = list(weights_per_mm3)
    while waiting and more:
        weight = waiting.pop(0)
        candidate = descend(refinement, refinement.weighed(design, weight), steps=steps, go_on=watched)
        if lands_there(world, candidate):
            design, good = candidate, weight
        elif good is None and weight < STRONGEST_PER_MM3:
            waiting = [3.0 * weight]
        else:
            break
    refinement.weight_per_mm3 = weights_per_mm3[0] if good is None else good
    return design
