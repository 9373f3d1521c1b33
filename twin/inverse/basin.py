"""Keep a design in the basin of its target: the ramp from the flat film must end in the shape that was designed."""

import logging
from collections.abc import Callable
from dataclasses import replace

from planner.errors import SolverError
from twin.equilibrium import rigid_distance_mm
from twin.inverse.refine import Design, Refinement
from twin.inverse.world import World

logger = logging.getLogger(__name__)

SAME_MM = 0.1
"""A designed shape and the ramp's are the same if no vertex is farther off, rigid motion aside."""
FIRST_FRUSTRATION_PER_MM3 = 1e-2
LEAST_FRUSTRATION_PER_MM3 = 3e-3
FACTOR = 3.0
SETTLED = 0.01
"""Relative gain of one step below which a design has settled."""


def descend(
    refinement: Refinement,
    design: Design,
    *,
    steps: int,
    go_on: Callable[[Design], bool],
) -> Design:
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
    steps: int,
    go_on: Callable[[Design], bool],
) -> Design:
    """Descend with as little weight on the energy left as keeps the design in the basin of its target.

    The film bends to the target along many paths of alignment. Those that leave much elastic energy at the target hold
    other shapes too, and from flat the film snaps into one of them. The weight falls as long as the ramp ends where
    it should, and rises where it does not.

    Args:
        refinement: what is minimised; its weight on the energy is changed.
        world: the nominal film.
        design: a design whose shape is where the ramp ends.
        steps: at most so many for each weight.
        go_on: called with each new design; False ends the search.
    """
    weight, failed = FIRST_FRUSTRATION_PER_MM3, False
    more = True

    def watched(candidate: Design) -> bool:
        nonlocal more
        more = go_on(candidate)
        return more

    while more:
        refinement.frustration_per_mm3 = weight
        start = replace(design, value=refinement.value(design.p, design.shapes))
        candidate = descend(refinement, start, steps=steps, go_on=watched)
        if lands_there(world, candidate):
            design = candidate
            if failed or weight <= LEAST_FRUSTRATION_PER_MM3:
                break
            weight = max(weight / FACTOR, LEAST_FRUSTRATION_PER_MM3)
        elif weight >= FIRST_FRUSTRATION_PER_MM3 * FACTOR**3 or (
            failed is False and weight < FIRST_FRUSTRATION_PER_MM3
        ):
            # a smaller weight was tried and left the basin: the design before it stands
            refinement.frustration_per_mm3 = weight * FACTOR
            break
        else:
            failed, weight = True, weight * FACTOR
    return design
