"""Measure the curvature field of a target: Step 1 of the paper."""

import logging
from typing import Literal

import numpy as np

from planner.curvature.field import CurvatureField
from planner.curvature.maximum import maximum_directions, whole_circle_inside
from planner.curvature.probe import CurvatureProbe, Plane
from planner.errors import InputError
from planner.target import Target, sample_surface

logger = logging.getLogger(__name__)

METHODS = ("perpendicular", "maximum")


def curvature_field(
    target: Target,
    *,
    method: Literal["perpendicular", "maximum"],
    neighbour_mm: float = 2.0,
    spacing_mm: float = 0.1,
    plane: Plane = "vertical",
) -> CurvatureField:
    """Measure direction and signed curvature at points all over the target (paper, section 2.3, Step 1).

    Each point P1 takes two neighbours on the surface, about `neighbour_mm` away in opposite horizontal directions; the
    circle through the three gives the curvature, positive where P1 lies above the chord (convex seen from above).

        perpendicular   one direction, across the incline (along the contour line)
        maximum         of 180 orientations, 1 degree apart, the one with the largest absolute curvature

    A point is dropped when a neighbour lies beyond the outline: with `maximum`, one of any orientation.

    Args:
        target: the surface.
        method: see above.
        neighbour_mm: distance of the neighbours from P1 along straight lines [mm]; the paper tried 1 to 4.
        spacing_mm: largest distance between adjacent sample points [mm].
        plane: whose curvature is reported, that of the circle in the `vertical` plane, as the paper's equations say,
            or the surface's `normal` curvature; see `CurvatureProbe`.

    Raises:
        InputError: for an unknown method or plane, a length that is not positive, or a target so small that every
            point has a neighbour beyond the outline.
    """
    _check(method, plane, neighbour_mm, spacing_mm)
    points = sample_surface(target, spacing_mm)
    probe = CurvatureProbe(target, neighbour_mm=neighbour_mm, plane=plane)
    sampled = len(points)
    if method == "maximum":
        points = points[whole_circle_inside(probe, points, neighbour_mm, target.outline_mm)]
        direction = maximum_directions(probe, points) if len(points) else np.zeros(0)
    else:
        direction = probe.contour_direction(probe.gradient(points[:, :2]))
    curvature = probe.curvature(points, probe.gradient(points[:, :2]), direction)
    kept = np.isfinite(curvature)
    if not kept.any():
        width, height = target.size_mm
        raise InputError(
            f"'{target.name}' is {width:.3g} x {height:.3g} mm: every point has a neighbour {neighbour_mm:g} mm away "
            f"beyond the outline; use a target wider than {2 * neighbour_mm:g} mm or a smaller neighbour_mm."
        )
    dropped = 1.0 - float(kept.sum()) / sampled
    logger.info("%s: %d points, %.1f %% dropped at the outline", method, kept.sum(), 100 * dropped)
    return CurvatureField(
        method=method,
        points_mm=points[kept],
        direction_rad=direction[kept],
        curvature_per_mm=curvature[kept],
        dropped_share=dropped,
    )


def _check(method: str, plane: str, neighbour_mm: float, spacing_mm: float) -> None:
    problems = []
    if method not in METHODS:
        problems.append(f"Curvature method '{method}' is unknown; choose one of {', '.join(METHODS)}.")
    if plane not in ("vertical", "normal"):
        problems.append(f"Curvature plane '{plane}' is unknown; choose vertical or normal.")
    for name, value in (("neighbour_mm", neighbour_mm), ("spacing_mm", spacing_mm)):
        if not (np.isfinite(value) and value > 0):
            problems.append(f"Curvature's {name} is {value}; it must be a positive length in mm, such as 1.")
    if problems:
        raise InputError(problems)
