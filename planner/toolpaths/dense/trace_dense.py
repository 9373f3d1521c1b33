"""Dense lines through a cloud of directions: the same result as `trace_passes`, by other means."""

import numpy as np
from scipy.spatial import KDTree

from planner.toolpaths.dense.cloud_field import CLOUD_LEAST, cloud_field
from planner.toolpaths.dense.lines import dense_lines
from planner.toolpaths.dense.polyline import spaced
from planner.toolpaths.trace import TracedPass, Tracing

NEIGHBOURS = 12
"""Cloud points whose mean curvature a point of a line takes."""
CHECK_LINES = 0.1
"""Distance, in line widths, of the points that stand for a line when the cloud's covered points are counted."""


def trace_dense(
    film_points: np.ndarray,
    direction_rad: np.ndarray,
    curvature: np.ndarray,
    rng: np.random.Generator,
    *,
    line_width_mm: float = 0.8,
) -> Tracing:
    """Tile a cloud with passes along its smoothed direction field; arguments as of `trace_passes`."""
    points = np.asarray(film_points, dtype=float).reshape(-1, 2)
    if len(points) == 0:
        return Tracing(passes=(), covered=np.zeros(0, dtype=bool), dropped=0)
    field = cloud_field(points, np.asarray(direction_rad, dtype=float), line_width_mm)
    seed = int(rng.integers(2**32))
    lines = dense_lines(field, line_width_mm=line_width_mm, least=CLOUD_LEAST, seed=seed)
    if not lines:
        return Tracing(passes=(), covered=np.zeros(len(points), dtype=bool), dropped=0)
    near = np.atleast_2d(KDTree(points).query(np.concatenate(lines), min(NEIGHBOURS, len(points)))[1].T).T
    mean = np.asarray(curvature)[near].mean(axis=1)
    bounds = np.cumsum([len(line) for line in lines])[:-1]
    passes = tuple(
        TracedPass(points_mm=line, curvature_per_mm=own)
        for line, own in zip(lines, np.split(mean, bounds), strict=True)
    )
    fine = np.concatenate([spaced(line, CHECK_LINES * line_width_mm) for line in lines])
    covered = np.isfinite(KDTree(fine).query(points, distance_upper_bound=line_width_mm / 2)[0])
    return Tracing(passes=passes, covered=covered, dropped=0)
