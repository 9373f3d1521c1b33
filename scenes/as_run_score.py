"""What the film is worth that was really scratched: planned against as run, both heated alike."""

from dataclasses import dataclass

from planner.program.as_run_film import AsRunFilm
from planner.target import Target
from scenes.sources import as_it_was_run
from twin.batch import heat_films
from twin.film import FilmOptions, build_film
from twin.predict import PredictOptions
from twin.score import Score, score_surface


@dataclass(frozen=True, kw_only=True)
class AsRunScores:
    """Scores of the two films."""

    planned: Score
    as_run: Score


def score_as_run(film: AsRunFilm, target: Target, options: PredictOptions | None = None) -> AsRunScores:
    """Heat the film as planned and as run, and score both.

    Raises:
        SolverError: if one of them finds no equilibrium.
    """
    options = options or PredictOptions(film=FilmOptions())
    planned = build_film(film.planned, options.film)
    made = build_film(film.program, as_it_was_run(options.film, film))
    shapes = heat_films([planned, made], options)
    scores = [score_surface(shape.top_mm, planned.triangles, target).score for shape in shapes]
    return AsRunScores(planned=scores[0], as_run=scores[1])
