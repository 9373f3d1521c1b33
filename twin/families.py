"""Heat one film several times, disturbed differently, and sort the shapes that come out."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from twin.cycle import rigid_distance_mm
from twin.film import Film
from twin.predict import HotShape, PredictOptions, heat_film

SAME_MM = 0.1
"""Shapes nearer to each other than this everywhere are one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Family:
    """Seeds that lead to the same shape."""

    shape: HotShape
    """The shape of the first of them."""
    seeds: tuple[int, ...]
    share: float
    """Share of all seeds (0..1)."""


def shapes_by_seed(
    film: Film,
    options: PredictOptions,
    count: int,
    *,
    progress: Callable[[str, float], None] | None = None,
) -> tuple[Family, ...]:
    """Heat `film` with `count` seeds from `options.seed` on; returns the families, the most frequent first.

    More than one family means that the film is bistable: which shape a real one takes depends on chance.

    Raises:
        ValueError: if count is not positive.
        SolverError: if a heating does not converge.
    """
    if count < 1:
        raise ValueError(f"count is {count}, must be at least 1")
    groups: list[tuple[HotShape, list[int]]] = []
    for number, seed in enumerate(range(options.seed, options.seed + count)):
        shape = heat_film(film, replace(options, seed=seed))
        for first, seeds in groups:
            if rigid_distance_mm(first.hot_mm, shape.hot_mm) < SAME_MM:
                seeds.append(seed)
                break
        else:
            groups.append((shape, [seed]))
        if progress is not None:
            progress("seeds", (number + 1) / count)
    groups.sort(key=lambda group: -len(group[1]))
    return tuple(Family(shape=shape, seeds=tuple(seeds), share=len(seeds) / count) for shape, seeds in groups)
