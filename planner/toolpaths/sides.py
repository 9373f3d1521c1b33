"""All passes of one side of the film: those that make it convex, or those that make it concave."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from planner.calibration import Calibration
from planner.program import Pass
from planner.toolpaths.coverage import Coverage, coverage
from planner.toolpaths.dense import CLOUD_LEAST, Tiling, cloud_field, tiling, trace_dense
from planner.toolpaths.order import order_passes
from planner.toolpaths.settings import set_passes
from planner.toolpaths.trace import Tracing, trace_passes

Side = Literal["convex", "concave"]
Tracer = Literal["greedy", "dense"]
"""`greedy`: the paper's paths, point by point through the cloud. `dense`: lines that tile the patterned region."""

SIDES: dict[Side, int] = {"convex": 1, "concave": -1}
"""Each side with the sign of its curvature, seen from above."""
LINE_WIDTH_MM = 0.8
STEP_MM = 0.8
MAX_TURN_DEG = 30.0


@dataclass(frozen=True, kw_only=True, eq=False)
class SideFigures:
    """What was asked of and done by the passes of one side."""

    points: int
    """Sample points that bend this way."""
    passes: int
    length_mm: float
    dropped: int
    """Paths of a single point, too short to scratch."""
    covered_share: float
    """Share of the points within half a line width of a pass (0..1)."""
    radius_error: float
    """Mean of `|given / wanted - 1|` over the passes' segments: what the choice of one load for a pass costs."""
    coverage: Coverage
    tiling: Tiling
    """How well the passes fill the patterned region, and follow its smoothed directions."""


def aligned_layers(layers: int, side: Side) -> tuple[int, ...]:
    """Return the layers to scratch: contraction in the lower half makes a film convex seen from above (paper, 2.3)."""
    half = layers // 2
    return tuple(range(half)) if side == "convex" else tuple(range(layers - half, layers))


def plan_side(
    side: Side,
    points: np.ndarray,
    direction: np.ndarray,
    curvature: np.ndarray,
    rng: np.random.Generator,
    calibration: Calibration,
    stack: tuple[tuple[float, ...], tuple[int, ...]],
    tracer: Tracer = "greedy",
) -> tuple[tuple[Pass, ...], SideFigures]:
    """Trace, set and order the passes of one side.

    Args:
        side: which way they bend the film.
        points: cloud on the film [mm], shape [n, 2].
        direction: direction at each point, modulo pi [rad], shape [n].
        curvature: signed curvature wanted at each point [1/mm], of the side's sign, shape [n].
        rng: chooses the starting points.
        calibration: post settings to bending radii.
        stack: thickness of each layer [mm], and which of them are scratched.
        tracer: how passes are traced.

    """
    if tracer == "dense":
        tracing = trace_dense(points, direction, curvature, rng, line_width_mm=LINE_WIDTH_MM)
    else:
        tracing = trace_passes(
            points,
            direction,
            curvature,
            rng,
            step_mm=STEP_MM,
            max_turn_rad=np.radians(MAX_TURN_DEG),
            line_width_mm=LINE_WIDTH_MM,
        )
    middle = [(stroke.curvature_per_mm[1:] + stroke.curvature_per_mm[:-1]) / 2 for stroke in tracing.passes]
    radius = [calibration.strip_radius_mm(1 / values, *stack) for values in middle]
    chosen = set_passes(tracing.passes, radius, calibration, side)
    passes = order_passes(chosen.passes)
    off = np.abs(chosen.given_radius_mm / chosen.wanted_radius_mm - 1)
    figures = SideFigures(
        points=len(points),
        passes=len(passes),
        length_mm=sum(stroke.length_mm for stroke in passes),
        dropped=tracing.dropped,
        covered_share=float(tracing.covered.mean()) if len(points) else 1.0,
        radius_error=float(off.mean()) if len(off) else 0.0,
        coverage=coverage(passes, LINE_WIDTH_MM),
        tiling=_tiling(tracing, points, direction),
    )
    return passes, figures


def _tiling(tracing: Tracing, points: np.ndarray, direction: np.ndarray) -> Tiling:
    if len(points) == 0:
        return Tiling.of_nothing(wanted=False)
    field = cloud_field(points, direction, LINE_WIDTH_MM)
    lines = [stroke.points_mm for stroke in tracing.passes]
    return tiling(lines, field, line_width_mm=LINE_WIDTH_MM, least=CLOUD_LEAST)
