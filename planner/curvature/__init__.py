"""Curvature: along which direction, and how sharply, each point of the target bends (paper, section 2.3, Step 1)."""

from planner.curvature.circumcircle import signed_curvature
from planner.curvature.field import CurvatureField
from planner.curvature.measure import curvature_field

__all__ = ["CurvatureField", "curvature_field", "signed_curvature"]
