"""Heat many films of one mesh together."""

from collections.abc import Callable, Sequence

import numpy as np

from planner.errors import InputError, SolverError
from twin.batch.together import run_together
from twin.film import Film
from twin.predict import HotShape, PredictOptions, heat_film


def heat_films(
    films: Sequence[Film],
    options: PredictOptions | None = None,
    *,
    lanes: int | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> list[HotShape]:
    """Heat films that differ in their layers but not in their mesh, each as `heat_film` does it alone.

    Args:
        films: the films.
        options: settings of all, one seed included.
        lanes: films at a time, see `run_together`.
        progress: called with the stage's name and the share of the films done, 0 to 1.

    Returns:
        One shape for each film, in their order; none depends on the other films.

    Raises:
        InputError: if an option is out of range or the films differ in their mesh.
        SolverError: if a film finds no equilibrium; the message says which.
    """
    options = options or PredictOptions()
    for number, film in enumerate(films):
        first = films[0]
        same = np.array_equal(film.triangles, first.triangles) and np.array_equal(film.flat_mm, first.flat_mm)
        if not same or len(film.contraction) != len(first.contraction):
            raise InputError(
                f"films: number {number + 1} has another mesh or number of layers than the first; a batch shares one "
                "mesh: build all films with the same outline and mesh size."
            )

    def job(number: int) -> Callable[[], HotShape]:
        def heat() -> HotShape:
            try:
                return heat_film(films[number], options)
            except SolverError as error:
                raise SolverError(f"film {number + 1} of {len(films)}: {error}") from error

        return heat

    jobs = [job(number) for number in range(len(films))]
    return run_together(jobs, device=options.device, lanes=lanes, progress=progress)
