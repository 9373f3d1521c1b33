"""Which errors of the process cost a film most, to first order in the errors."""

import numpy as np

from planner.target import Target
from twin.batch import ProcessNoise
from twin.film import Film
from twin.inverse.expected_loss import NOISE_HEIGHTS, NOISE_OUTLINE
from twin.inverse.mismatch import Mismatch
from twin.inverse.noise import ProcessErrors
from twin.inverse.world import World
from twin.predict import PredictOptions
from twin.temperature import TemperatureUniform


def noise_costs(
    film: Film, vertices_mm: np.ndarray, target: Target, noise: ProcessNoise, heated: PredictOptions
) -> dict[str, float] | None:
    """Return what each kind of error is expected to cost in similarity, by its name in `ProcessNoise`.

    The expected loss of `twin.inverse.expected_loss`, of each kind alone: half the sum of u^t C u over the
    displacements u that one standard deviation of each error makes, in the quadratic form C of what displacements cost.
    Kinds are independent, so that their costs add up. A film that is soft loses less than its first order says, one
    that snaps loses more; C holds near the target, and far from it overstates all costs alike.

    Args:
        film: the film as planned.
        vertices_mm: its hot mid-surface [mm], shape [n, 3].
        target: what it should become.
        noise: standard deviations.
        heated: how the film was heated.

    Returns:
        The costs [1]; None where there is no first order: the equilibrium is not stable, or the temperature depends on
        the film's shape or place.

    Raises:
        SolverError: if there is no equilibrium near the vertices.
    """
    if not isinstance(heated.temperature_field, TemperatureUniform):
        return None
    world = World(film, Mismatch(target, film.triangles), heated)
    try:
        q = film.alignment
        shape = world.settle(q, vertices_mm)
        if not world.linearise(q, shape.vertices_mm):
            return None
        cost = shape.measured.model.weighed(heights=NOISE_HEIGHTS, outline=NOISE_OUTLINE)
        kinds = ProcessErrors(film, noise, seed=heated.seed).kinds(q)
        moved = {kind: world.push(np.stack(changes)) for kind, changes in kinds.items()}
        return {kind: 0.5 * sum(float((u * cost.curve(u)).sum()) for u in moves) for kind, moves in moved.items()}
    finally:
        world.newton.close()
