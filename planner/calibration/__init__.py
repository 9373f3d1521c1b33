"""Post load and speed <-> bending radius <-> contraction, and the bending of a wide strip behind it."""

from planner.calibration.calibration import Calibration, Settings
from planner.calibration.files import load_calibration
from planner.calibration.fit import CalibrationFit, fit_calibration
from planner.calibration.outliers import Outlier
from planner.calibration.skin import skin_depth_mm, skin_radius_mm
from planner.calibration.strip_width import curvature_at_width, width_factor
from planner.calibration.strips_file import MeasuredStrips, read_strips
from planner.calibration.wide_strip import contraction_for_radius, radius_for_contraction, wide_stack, wide_strip
from planner.calibration.written import calibration_toml

__all__ = [
    "Calibration",
    "CalibrationFit",
    "MeasuredStrips",
    "Outlier",
    "Settings",
    "calibration_toml",
    "contraction_for_radius",
    "curvature_at_width",
    "fit_calibration",
    "load_calibration",
    "radius_for_contraction",
    "read_strips",
    "skin_depth_mm",
    "skin_radius_mm",
    "wide_stack",
    "wide_strip",
    "width_factor",
]
