"""Neighbour points at a given distance along the surface."""

import numpy as np

from planner.curvature.continuation import Height

TOLERANCE = 1e-3
"""Accepted misfit of the distance, as a share of it; the circle uses the actual distances in any case."""
MOST_STEPS = 12
"""Search steps; a face needs two to three, the steepest walls of a skull all of them."""


def neighbour(
    height: Height, points_mm: np.ndarray, along_x: np.ndarray, along_y: np.ndarray, distance_mm: float
) -> tuple[np.ndarray, np.ndarray]:
    """Step over the surface until the straight 3-D distance from the start is `distance_mm`.

    Args:
        height: the surface.
        points_mm: start points on it [mm], shape [n, 3].
        along_x: x component of the horizontal unit direction of each step, shape [n].
        along_y: y component, shape [n].
        distance_mm: wanted distance [mm].

    Returns:
        Horizontal distance [mm] and rise [mm] from each start to its neighbour, each shape [n].
    """
    x, y, z = points_mm.T
    step = np.full(len(points_mm), distance_mm)
    rise = height(x + step * along_x, y + step * along_y) - z
    misfit = np.hypot(step, rise) - distance_mm

    # The wanted step lies in [0, distance], as d(0) = 0 and d(distance) >= distance. False position with the Illinois
    # rule (an end that stays has its misfit halved) is exact after one step on a plane, and stays bracketed and quick
    # where a wall makes d bend or jump. Only the points that still search are evaluated.
    active = np.flatnonzero(misfit > TOLERANCE * distance_mm)
    low, high = np.zeros(len(active)), step[active]
    misfit_low, misfit_high = np.full(len(active), -distance_mm), misfit[active]
    was_beyond = np.ones(len(active), dtype=bool)
    for _ in range(MOST_STEPS):
        if len(active) == 0:
            break
        trial = low - misfit_low * (high - low) / (misfit_high - misfit_low)
        trial_rise = height(x[active] + trial * along_x[active], y[active] + trial * along_y[active]) - z[active]
        trial_misfit = np.hypot(trial, trial_rise) - distance_mm
        step[active], rise[active] = trial, trial_rise
        beyond = trial_misfit >= 0
        weight = np.where(beyond == was_beyond, 0.5, 1.0)
        low, misfit_low = np.where(beyond, low, trial), np.where(beyond, weight * misfit_low, trial_misfit)
        high, misfit_high = np.where(beyond, trial, high), np.where(beyond, trial_misfit, weight * misfit_high)
        search = abs(trial_misfit) > TOLERANCE * distance_mm
        active, was_beyond, low, high, misfit_low, misfit_high = (
            values[search] for values in (active, beyond, low, high, misfit_low, misfit_high)
        )
    return step, rise
