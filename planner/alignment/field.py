"""The alignment that a plan wants of each layer, point by point on the film."""

from dataclasses import dataclass

import numpy as np

from planner.calibration import Calibration, contraction_for_radius
from planner.curvature import CurvatureField
from planner.flattening import Flattening, map_directions, map_points


@dataclass(frozen=True, kw_only=True, eq=False)
class AlignmentField:
    """Director and contraction of each layer at points of the film, as q = e (cos 2 theta, sin 2 theta).

    The double angle makes a director and its opposite the same; q = 0 is polydomain.
    """

    points_mm: np.ndarray
    """Points on the film [mm], shape [n, 2], float."""
    q: np.ndarray
    """Alignment vectors, layer 0 at the bottom, shape [layers, n, 2], float."""


def bending_field(
    curvature: CurvatureField, flattening: Flattening, calibration: Calibration, *, layer_count: int = 4
) -> AlignmentField:
    """Return the ideal field of the paper's curvature plans.

    The lower half of the layers bends the convex points, the upper half the concave ones, each by the contraction
    that gives its radius, clamped to the calibration's range.
    """
    points = map_points(flattening, curvature.points_mm[:, :2])
    direction = map_directions(flattening, curvature.points_mm[:, :2], curvature.direction_rad)
    kept = np.isfinite(points).all(axis=1) & np.isfinite(direction)
    limits, strip = calibration.record.limits, calibration.record.strip
    bent = curvature.curvature_per_mm[kept]
    stack = (strip.layer_thickness_mm, strip.aligned_layers)
    wanted = calibration.strip_radius_mm(1.0 / np.maximum(np.abs(bent), 1e-9), *stack)
    radius = np.clip(wanted, limits.radius_mm_min, limits.radius_mm_max)
    contraction = contraction_for_radius(radius, *stack, strip.width_mm)
    vector = contraction[:, None] * np.column_stack((np.cos(2 * direction[kept]), np.sin(2 * direction[kept])))
    q = np.zeros((layer_count, len(vector), 2))
    lower = layer_count // 2
    q[:lower, bent > 0] = vector[bent > 0]
    q[layer_count - lower :, bent < 0] = vector[bent < 0]
    return AlignmentField(points_mm=points[kept], q=q)
