"""Post load and speed <-> bending radius <-> contraction, and the bending of a wide strip behind it."""

from planner.calibration.calibration import Calibration, Settings
from planner.calibration.files import load_calibration
from planner.calibration.skin import skin_depth_mm, skin_radius_mm
from planner.calibration.wide_strip import contraction_for_radius, radius_for_contraction, wide_stack, wide_strip

__all__ = [
    "Calibration",
    "Settings",
    "contraction_for_radius",
    "load_calibration",
    "radius_for_contraction",
    "skin_depth_mm",
    "skin_radius_mm",
    "wide_stack",
    "wide_strip",
]
