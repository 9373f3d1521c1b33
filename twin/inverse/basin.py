"""Keep a design in the basin of its target: the ramp from the flat film must end in the shape that was designed."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace

from planner.errors import SolverError
from twin.equilibrium import rigid_distance_mm
from twin.inverse.refine import Design, Refinement
from twin.inverse.world import World

logger = logging.getLogger(__name__)

SAME_MM = 0.1
"""A designed shape and the ramp's are the same if no vertex is farther off, rigid motion aside."""
WEIGHTS_PER_MM3 = (1e-2, 3e-3, 1e-3)
"""Weights of the anchor, from the one that holds nearly every film in the basin of its target downwards."""
FACTOR = 3.0
STRONGEST_PER_MM3 = 0.05
RENEWED_AFTER = 4
"""Steps after which a robust design looks again for the errors that it suffers most from."""
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
    for number in range(steps):
        if number % RENEWED_AFTER == 0:
            design = refinement.renewed(design)
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
    found = world.settle(design.q, world.ramp(design.q), design.nominal)
    off = rigid_distance_mm(found.vertices_mm, design.nominal.vertices_mm)
    logger.info("ramp from flat: %.3f mm off, ssim %.4f", off, found.measured.ssim)
    if off < SAME_MM:
        return design, True
    shapes = (found, *design.shapes[1:])
    return replace(design, shapes=shapes, value=refinement.value(design.p, design.q, shapes)), False


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
        world: the nominal film.
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
        if best is None or design.nominal.measured.value < best[0].nominal.measured.value:
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
