"""How the score of any Program spreads over films with errors of the process."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planner.program import Program
from planner.target import Target
from twin.batch import ProcessNoise, heat_films, noisy_films
from twin.film import build_film
from twin.inverse import noise_costs
from twin.predict import PredictOptions
from twin.score import Score, score_surface

MESH_MM = 0.8
"""Edge of the films' triangles where none is asked for. On 1.2 mm a film is so much too shallow that one face of six
scores 0.02 less as planned, as if it contracted 3 % less, and 0.016 less at its tenth percentile (decision 0014)."""
PERCENTILES = (10, 50, 90)


@dataclass(frozen=True, kw_only=True)
class Robustness:
    """Scores of noisy films and of the film as planned, all on one mesh."""

    noise: ProcessNoise
    seed: int
    mesh_mm: float
    planned: Score
    """Without noise."""
    scores: tuple[Score, ...]
    contraction: tuple[float, ...]
    """Contraction of each film over the planned one's, both averaged over their layers and area."""
    costs: dict[str, float] | None
    """What errors cost the planned film by its answer to first order, see `noise_costs`."""


def for_many_films(options: PredictOptions, mesh_mm: float) -> PredictOptions:
    """Return the settings for one temperature, the highest, on a mesh with such edges unless theirs are longer."""
    return replace(
        options,
        film=replace(options.film, mesh_mm=max(mesh_mm, options.film.mesh_mm)),
        temperature_c=options.hottest_c,
        temperatures_c=None,
    )


def score_noisy_films(
    program: Program,
    target: Target,
    options: PredictOptions,
    noise: ProcessNoise,
    count: int,
    *,
    mesh_mm: float = MESH_MM,
    progress: Callable[[str, float], None] | None = None,
) -> Robustness:
    """Heat and score films that differ by the noise of the process.

    Args:
        program: what is scratched.
        target: what to score against.
        options: settings of the twin, its seed also that of the noise; of several temperatures only the highest
            counts.
        noise: standard deviations.
        count: number of noisy films.
        mesh_mm: edge of the films' triangles, unless that of the options is longer.
        progress: called with the stage's name and the share done, 0 to 1.

    Raises:
        InputError: for noise out of range, or that does not fit the film.
        SolverError: if a film finds no equilibrium.
    """
    coarse = for_many_films(options, mesh_mm)
    film = build_film(program, coarse.film)
    films = [film, *noisy_films(film, noise, count, options.seed)]
    shapes = heat_films(films, coarse, progress=progress)
    whole = [own.area_mm2 @ own.contraction.sum(axis=0) for own in films]
    planned, *scores = (score_surface(shape.top_mm, film.triangles, target).score for shape in shapes)
    return Robustness(
        noise=noise,
        seed=options.seed,
        mesh_mm=coarse.film.mesh_mm,
        planned=planned,
        scores=tuple(scores),
        contraction=tuple(float(own / whole[0]) if whole[0] else 1.0 for own in whole[1:]),
        costs=noise_costs(film, shapes[0].hot_mm, target, noise, coarse),
    )


def robustness_summary(found: Robustness) -> dict[str, Any]:
    """Collect the figures as plain values for `result.json`."""
    values = {name: [getattr(score, name) for score in found.scores] for name in ("ssim_eq4", "rms_mm")}
    return {
        "count": len(found.scores),
        "seed": found.seed,
        "mesh_mm": found.mesh_mm,
        "standard_deviations": found.noise.plain(),
        "without_noise": {name: getattr(found.planned, name) for name in values},
        **values,
        "contraction_share": list(found.contraction),
        "expected_cost": found.costs,
        "percentiles": {
            name: dict(zip(map(str, PERCENTILES), np.percentile(own, PERCENTILES), strict=True))
            for name, own in values.items()
        },
    }
