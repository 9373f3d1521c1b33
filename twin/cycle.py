"""Heat a film and cool it again: does it come back, and did it snap on the way?"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from twin.equilibrium import cool, heat
from twin.film import Film
from twin.predict import PredictOptions, open_newton, ramp_end, ramp_temperatures_c

SNAP_MM = 0.05
"""Heated and cooled shapes that differ by more at the same temperature are different equilibria."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Cycle:
    """Shapes of one film while it is heated and while it is cooled, at the same temperatures."""

    temperature_c: np.ndarray
    """Accepted temperatures, ascending [C], shape [k]."""
    heated_mm: np.ndarray
    """Mid-surface on the way up [mm], shape [k, n, 3]."""
    cooled_mm: np.ndarray
    """Mid-surface on the way down, cold first [mm], shape [k, n, 3]."""
    difference_mm: np.ndarray
    """Largest distance between the two at each temperature, after a rigid motion [mm], shape [k]."""

    @property
    def back_to_flat_mm(self) -> float:
        """How far the cooled film is from the one before heating [mm]."""
        return float(self.difference_mm[0])

    @property
    def snaps_between_c(self) -> tuple[tuple[float, float], ...]:
        """Temperature ranges over which heating and cooling took different paths: the film snaps at their ends."""
        apart = np.flatnonzero(self.difference_mm > SNAP_MM)
        runs = np.split(apart, np.flatnonzero(np.diff(apart) > 1) + 1) if len(apart) else []
        return tuple((float(self.temperature_c[run[0]]), float(self.temperature_c[run[-1]])) for run in runs)


def heat_and_cool(
    film: Film, options: PredictOptions | None = None, *, progress: Callable[[str, float], None] | None = None
) -> Cycle:
    """Heat a film from flat and cool it through the same temperatures, all on its own mesh.

    Args:
        film: the film.
        options: settings; `coarse_to_fine` is not used.
        progress: called with the stage's name and the share done, 0 to 1.

    Raises:
        SolverError: if no equilibrium is found on the way.
    """
    options = options or PredictOptions()
    report = progress or (lambda stage, share: None)
    newton = open_newton(film, options)
    try:
        heated = heat(
            newton,
            ramp_end(options),
            rng=np.random.default_rng(options.seed),
            options=options.ramp,
            progress=lambda share: report("heating", share),
        )
        cooled = cool(newton, heated, options=options.ramp, progress=lambda share: report("cooling", share))
    finally:
        newton.close()
    up = np.stack([state.equilibrium.vertices_mm for state in heated])
    down = np.stack([state.equilibrium.vertices_mm for state in cooled])
    return Cycle(
        temperature_c=ramp_temperatures_c(heated, options),
        heated_mm=up,
        cooled_mm=down,
        difference_mm=np.array([rigid_distance_mm(a, b) for a, b in zip(up, down, strict=True)]),
    )


def rigid_distance_mm(shape_mm: np.ndarray, other_mm: np.ndarray) -> float:
    """Return the largest distance of corresponding vertices after the best rigid motion [mm], shapes [n, 3]."""
    a, b = shape_mm - shape_mm.mean(axis=0), other_mm - other_mm.mean(axis=0)
    u, _, vt = np.linalg.svd(a.T @ b)
    turn = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
    return float(np.linalg.norm(a @ turn - b, axis=1).max())
