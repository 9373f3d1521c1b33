"""How far the score of a Program is open because its calibration is not known better."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from planner.calibration import Calibration
from planner.program import Program
from planner.target import Target
from scenes.robustness import PERCENTILES, for_many_films
from twin.batch import heat_films
from twin.film import build_film
from twin.predict import PredictOptions
from twin.score import Score, score_surface

MESH_MM = 1.2
"""Edge of the films' triangles: many films in little more time than one takes; what counts is how scores differ."""


@dataclass(frozen=True, kw_only=True)
class CalibrationBand:
    """Scores of one Program under maps of load and speed that the calibration's strips leave possible."""

    seed: int
    mesh_mm: float
    expected: Score
    """Under the calibration itself, on the same mesh."""
    scores: tuple[Score, ...]


def score_drawn_calibrations(
    program: Program,
    target: Target,
    options: PredictOptions,
    count: int,
    *,
    progress: Callable[[str, float], None] | None = None,
) -> CalibrationBand:
    """Heat and score the film of a Program as maps drawn from its calibration's uncertainty would have made it.

    Each map is drawn as a whole, so that contraction is off alike wherever load and speed are alike.

    Args:
        program: what is scratched; its calibration says how uncertain it is.
        target: what to score against.
        options: settings of the twin, its seed also that of the draws; coarsened by `for_many_films`.
        count: number of drawn maps.
        progress: called with the stage's name and the share done, 0 to 1.

    Raises:
        SolverError: if a film finds no equilibrium.
    """
    coarse = for_many_films(options, MESH_MM)
    calibration, rng = Calibration(program.calibration), np.random.default_rng((options.seed, count))
    drawn = [program.model_copy(update={"calibration": calibration.drawn(rng).record}) for _ in range(count)]
    films = [build_film(one, coarse.film) for one in (program, *drawn)]
    shapes = heat_films(films, coarse, progress=progress)
    expected, *scores = (score_surface(shape.top_mm, shape.film.triangles, target).score for shape in shapes)
    return CalibrationBand(seed=options.seed, mesh_mm=coarse.film.mesh_mm, expected=expected, scores=tuple(scores))


def band_summary(found: CalibrationBand, name: str) -> dict[str, Any]:
    """Collect the figures as plain values for `result.json`."""
    numbers = {}
    for key in ("ssim_eq4", "rms_mm"):
        own = [getattr(score, key) for score in found.scores]
        low, median, high = np.percentile(own, PERCENTILES)
        expected = getattr(found.expected, key)
        numbers[key] = {"low": low, "median": median, "high": high, "expected": expected, "drawn": own}
    return {
        "calibration": name,
        "percent": PERCENTILES,
        "draws": len(found.scores),
        "seed": found.seed,
        "mesh_mm": found.mesh_mm,
        **numbers,
    }
