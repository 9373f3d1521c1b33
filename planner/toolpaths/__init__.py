"""Toolpaths: from directions and curvatures on the film to passes (paper, section 2.3, Step 3)."""

from planner.toolpaths.coverage import Coverage, coverage, swept_area
from planner.toolpaths.order import order_passes, travel_mm
from planner.toolpaths.settings import PassSettings, load_levels, set_passes
from planner.toolpaths.trace import TracedPass, Tracing, trace_passes

__all__ = [
    "Coverage",
    "PassSettings",
    "TracedPass",
    "Tracing",
    "coverage",
    "load_levels",
    "order_passes",
    "set_passes",
    "swept_area",
    "trace_passes",
    "travel_mm",
]
