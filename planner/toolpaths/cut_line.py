"""The line along which the finished film is cut: it follows the patterned region (paper, section 4.2)."""

from dataclasses import dataclass

import numpy as np
import shapely
from scipy.ndimage import gaussian_filter1d

GAP_MM = 1.5
"""Gaps and notches up to twice this wide are bridged: the ends of passes are ragged by up to a step."""
SPACING_MM = 0.4
"""Distance between the points of the line."""
SMOOTHING_MM = 1.2
"""Standard deviation of the smoothing along the line; rounds a corner, moves a 20 mm circle by 0.04 mm."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CutLine:
    """One closed line, and what lies beyond it."""

    line_mm: np.ndarray
    """Closed line [mm], counter-clockwise, first point not repeated, shape [n, 2], float."""
    piece: shapely.Polygon
    """The connected region that the line goes round."""
    lost_mm2: float
    """Patterned area in other, unconnected pieces [mm2]."""
    lost_pieces: int


def cut_line(swept: shapely.Geometry, margin_mm: float = 0.0) -> CutLine:
    """Draw a smooth line around the largest connected piece of the patterned region.

    Args:
        swept: area that the passes align (see `swept_area`), not empty.
        margin_mm: width of unaligned film to leave around it [mm].

    """
    closed = shapely.buffer(shapely.buffer(swept, GAP_MM), -GAP_MM)
    pieces = sorted(_polygons(closed), key=lambda piece: piece.area, reverse=True)
    largest = shapely.Polygon(pieces[0].exterior)
    smooth = shapely.Polygon(_smoothed(np.asarray(largest.exterior.coords)[:-1]))
    if margin_mm > 0:
        smooth = shapely.buffer(smooth, margin_mm)
    # A neck thinner than the smoothing can pinch off: the largest part is the film.
    outline = max(_polygons(shapely.make_valid(smooth)), key=lambda piece: piece.area)
    line = np.asarray(shapely.orient_polygons(shapely.Polygon(outline.exterior)).exterior.coords)[:-1]
    lost = [piece for piece in pieces[1:] if not largest.contains(piece)]
    return CutLine(
        line_mm=_resampled(line) if margin_mm > 0 else line,
        piece=shapely.Polygon(outline.exterior),
        lost_mm2=float(sum(piece.area for piece in lost)),
        lost_pieces=len(lost),
    )


def _polygons(geometry: shapely.Geometry) -> list[shapely.Polygon]:
    return [part for part in shapely.get_parts(geometry) if isinstance(part, shapely.Polygon)]


def _smoothed(line: np.ndarray) -> np.ndarray:
    return gaussian_filter1d(_resampled(line), SMOOTHING_MM / SPACING_MM, axis=0, mode="wrap")


def _resampled(line: np.ndarray) -> np.ndarray:
    """Space the points of a closed line evenly, about `SPACING_MM` apart."""
    ring = np.vstack([line, line[:1]])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))])
    places = np.linspace(0, along[-1], max(12, round(along[-1] / SPACING_MM)), endpoint=False)
    return np.stack([np.interp(places, along, ring[:, axis]) for axis in (0, 1)], axis=1)
