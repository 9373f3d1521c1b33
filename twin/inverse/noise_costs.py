"""Which errors of the process cost a film most, by its first-order answer to them."""

import numpy as np
from scipy.stats.qmc import MultivariateNormalQMC

from planner.target import Target
from twin.batch import ProcessNoise
from twin.film import Film
from twin.inverse.mismatch import Mismatch
from twin.inverse.noise import ProcessErrors
from twin.inverse.world import World
from twin.predict import PredictOptions
from twin.temperature import TemperatureUniform

DRAWS = 16
"""Draws of a kind's errors, each taken to both sides."""
TOGETHER = "together"


def noise_costs(
    film: Film, vertices_mm: np.ndarray, target: Target, noise: ProcessNoise, heated: PredictOptions
) -> dict[str, float] | None:
    """Return what errors cost in similarity on average: each kind alone, by its name in `ProcessNoise`, and `together`.

    Only displacements are of first order: the hot shape is moved by them and really scored, since a rim that moves
    costs about its distance, not the square of it. Films that snap lose more. Costs do not add up.

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
    mismatch = Mismatch(target, film.triangles)
    world = World(film, mismatch, heated)
    try:
        q = film.alignment
        shape = world.settle(q, vertices_mm)
        if not world.linearise(q, shape.vertices_mm):
            return None
        kinds = ProcessErrors(film, noise, seed=heated.seed).kinds(q)
        answers = {kind: world.push(np.stack(changes)) for kind, changes in kinds.items()}
        measured = shape.measured
        top_mm = measured.transform.apply(shape.top_mm)

        def similarity(move_mm: np.ndarray) -> float:
            return mismatch.similarity(top_mm + measured.model.aligned(move_mm))

        def cost(answer: np.ndarray) -> float:
            if not answer.any():
                return 0.0
            drawn = MultivariateNormalQMC(np.zeros(len(answer)), rng=heated.seed).random(DRAWS)
            moves = np.tensordot(drawn, answer, axes=1)
            return measured.ssim - float(np.mean([similarity(move) for move in (*moves, *-moves)]))

        together = np.concatenate(list(answers.values()))
        return {**{kind: cost(answer) for kind, answer in answers.items()}, TOGETHER: cost(together)}
    finally:
        world.newton.close()
