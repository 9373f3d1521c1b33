"""Toolpaths: from directions and curvatures on the film to passes (paper, section 2.3, Step 3)."""

from planner.toolpaths.coverage import Coverage, coverage, swept_area
from planner.toolpaths.cut_line import CutLine, cut_line
from planner.toolpaths.order import order_passes, travel_mm
from planner.toolpaths.settings import PassSettings, load_levels, set_passes
from planner.toolpaths.sides import (
    LINE_WIDTH_MM,
    MAX_TURN_DEG,
    SIDES,
    STEP_MM,
    Side,
    SideFigures,
    Tracer,
    aligned_layers,
    plan_side,
)
from planner.toolpaths.trace import TracedPass, Tracing, trace_passes

__all__ = [
    "LINE_WIDTH_MM",
    "MAX_TURN_DEG",
    "SIDES",
    "STEP_MM",
    "Coverage",
    "CutLine",
    "PassSettings",
    "Side",
    "SideFigures",
    "TracedPass",
    "Tracer",
    "Tracing",
    "aligned_layers",
    "coverage",
    "cut_line",
    "load_levels",
    "order_passes",
    "plan_side",
    "set_passes",
    "swept_area",
    "trace_passes",
    "travel_mm",
]
