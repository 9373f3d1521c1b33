"""How much of a film its passes align, and where they overlap."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import shapely

from planner.program import Pass


@dataclass(frozen=True, kw_only=True)
class Coverage:
    """Areas that the passes of one layer sweep."""

    aligned_mm2: float
    """Area within half a line width of a pass [mm2]."""
    swept_mm2: float
    """Sum of the areas of all passes, each counted alone [mm2]."""

    @property
    def overlap(self) -> float:
        """Share of the swept area that lands on film that another pass aligns too (0..1)."""
        return 1 - self.aligned_mm2 / self.swept_mm2 if self.swept_mm2 else 0.0


def swept_area(passes: Sequence[Pass], line_width_mm: float) -> shapely.Polygon | shapely.MultiPolygon:
    """Return the union of all passes, each as wide as the line, with round ends."""
    lines = [shapely.LineString(stroke.points_mm) for stroke in passes]
    union = shapely.union_all(shapely.buffer(lines, line_width_mm / 2, quad_segs=4))
    return cast(shapely.Polygon | shapely.MultiPolygon, union)


def coverage(passes: Sequence[Pass], line_width_mm: float) -> Coverage:
    """Measure the aligned area and the overlap of passes."""
    lines = [shapely.LineString(stroke.points_mm) for stroke in passes]
    areas = shapely.area(shapely.buffer(lines, line_width_mm / 2, quad_segs=4))
    aligned = swept_area(passes, line_width_mm).area
    return Coverage(aligned_mm2=aligned, swept_mm2=float(areas.sum()))
