"""Paint passes into fields of director and contraction."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import gaussian_filter, map_coordinates

from planner.calibration import Calibration
from planner.program import Pass

PIXEL_MM = 0.1


@dataclass(frozen=True, kw_only=True, eq=False)
class AlignmentRaster:
    """A layer's alignment on a pixel grid, as the vector q = e (cos 2 theta, sin 2 theta): 0 is polydomain.

    The double angle makes opposite scratch directions the same, and averages without an angle's jump.
    """

    origin_mm: np.ndarray
    """Centre of pixel [0, 0] [mm], shape [2]."""
    q: np.ndarray
    """The two components, shape [2, rows, columns], float; rows along y."""

    def sample(self, points_mm: np.ndarray) -> np.ndarray:
        """Interpolate q at points [mm], shape [..., 2] -> [..., 2]; zero beyond the grid."""
        place = (points_mm - self.origin_mm) / PIXEL_MM
        rows_columns = np.stack((place[..., 1].ravel(), place[..., 0].ravel()))
        values = [map_coordinates(part, rows_columns, order=1, mode="constant") for part in self.q]
        return np.stack(values, axis=-1).reshape(points_mm.shape)


@dataclass(frozen=True, kw_only=True, eq=False)
class Strokes:
    """A layer's passes cut into straight pieces, and which of them aligned each pixel last."""

    origin_mm: np.ndarray
    """Centre of pixel [0, 0] [mm], shape [2]."""
    owner: np.ndarray
    """Piece that aligned each pixel last, -1 where none did, shape [rows, columns], int."""
    contraction: np.ndarray
    """Contraction of each piece, shape [pieces]."""
    director: np.ndarray
    """(cos 2 theta, sin 2 theta) of each piece, shape [pieces, 2]."""
    segment: np.ndarray
    """Segment that each piece is a part of, counted through all passes in their order, shape [pieces], int."""


def paint_passes(
    passes: Sequence[Pass],
    calibration: Calibration,
    bounds_mm: tuple[np.ndarray, np.ndarray],
    *,
    line_width_mm: float,
    edge_blur_mm: float,
    end_length_mm: float = 0.0,
    strength: ArrayLike | None = None,
) -> AlignmentRaster:
    """Return what a layer remembers of the passes scratched into it, in their order.

    Args:
        passes: the layer's passes.
        calibration: map from load [g] and speed [mm/s] to contraction.
        bounds_mm: lower left and upper right corner of the painted region [mm].
        line_width_mm: width of the scratched line [mm].
        edge_blur_mm: standard deviation of a Gaussian that softens the lines' edges [mm], 0 for sharp edges.
        end_length_mm: way that the post moves at the start of each pass before it aligns [mm].
        strength: factor on the contraction of each pass, as for fading, shape [passes]; None for 1.
    """
    strokes = follow_passes(
        passes, calibration, bounds_mm, line_width_mm=line_width_mm, end_length_mm=end_length_mm, strength=strength
    )
    q = np.zeros((2, *strokes.owner.shape))
    painted = strokes.owner >= 0
    vectors = strokes.contraction * strokes.director.T
    q[:, painted] = vectors[:, strokes.owner[painted]]
    if edge_blur_mm > 0.0:
        q = np.stack([gaussian_filter(part, edge_blur_mm / PIXEL_MM, mode="constant") for part in q])
    return AlignmentRaster(origin_mm=strokes.origin_mm, q=q)


def follow_passes(
    passes: Sequence[Pass],
    calibration: Calibration,
    bounds_mm: tuple[np.ndarray, np.ndarray],
    *,
    line_width_mm: float,
    end_length_mm: float = 0.0,
    strength: ArrayLike | None = None,
) -> Strokes:
    """Return which piece of which pass aligned each pixel last; arguments as of `paint_passes`.

    The post aligns a stadium of `line_width_mm` around each segment along the segment's direction; where passes
    overlap the later one overwrites, within one pass the nearest segment counts. Contraction follows from load and
    speed by the calibration.
    """
    low, high = bounds_mm
    columns, rows = np.ceil((high - low) / PIXEL_MM).astype(int) + 1
    origin = np.asarray(low, dtype=float)
    if not passes:
        empty = np.empty(0)
        owner = np.full((rows, columns), -1)
        return Strokes(
            origin_mm=origin,
            owner=owner,
            contraction=empty,
            director=np.empty((0, 2)),
            segment=np.empty(0, dtype=int),
        )
    start, end, contraction, stroke, segment = _pieces(passes, calibration, line_width_mm)
    if strength is not None:
        contraction = contraction * np.asarray(strength, dtype=float)[stroke]
    if end_length_mm > 0.0:
        kept, start = _dragged(start, end, stroke, end_length_mm)
        start, end, contraction = start[kept], end[kept], contraction[kept]
        stroke, segment = stroke[kept], segment[kept]
    along = end - start
    double = 2.0 * np.arctan2(along[:, 1], along[:, 0])
    return Strokes(
        origin_mm=origin,
        owner=_owners(start, end, stroke, low, (int(rows), int(columns)), line_width_mm),
        contraction=contraction,
        director=np.stack((np.cos(double), np.sin(double)), axis=1),
        segment=segment,
    )


def _pieces(
    passes: Sequence[Pass], calibration: Calibration, longest_mm: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Cut all passes into straight pieces no longer than the line is wide.

    Returns start, end, contraction, pass and segment of each.
    """
    starts, ends, loads, speeds, strokes, segments, before = [], [], [], [], [], [], 0
    for number, stroke in enumerate(passes):
        points = np.asarray(stroke.points_mm)
        load = np.broadcast_to(np.asarray(stroke.load_g, dtype=float), len(points))
        count = np.maximum(1, np.ceil(np.linalg.norm(np.diff(points, axis=0), axis=1) / longest_mm).astype(int))
        segment = np.repeat(np.arange(len(count)), count)
        first = np.concatenate([np.arange(n) / n for n in count])
        step = (1.0 / count)[segment]
        a, b = points[segment], points[segment + 1]
        starts.append(a + first[:, None] * (b - a))
        ends.append(a + (first + step)[:, None] * (b - a))
        loads.append(load[segment] + (first + 0.5 * step) * (load[segment + 1] - load[segment]))
        speeds.append(np.asarray(stroke.speed_mm_s)[segment])
        strokes.append(np.full(len(segment), number))
        segments.append(before + segment)
        before += len(count)
    contraction = calibration.contraction(np.concatenate(loads), np.concatenate(speeds))
    return (
        np.concatenate(starts),
        np.concatenate(ends),
        contraction,
        np.concatenate(strokes),
        np.concatenate(segments),
    )


def _dragged(
    start: np.ndarray, end: np.ndarray, stroke: np.ndarray, end_length_mm: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return which pieces end farther than `end_length_mm` into their pass, and starts no nearer than that."""
    length = np.linalg.norm(end - start, axis=1)
    gone = np.cumsum(length)
    first = np.concatenate(([True], np.diff(stroke) > 0))
    gone -= (gone - length)[np.flatnonzero(first)][np.cumsum(first) - 1]
    missing = np.clip(end_length_mm - (gone - length), 0.0, length)
    moved = start + (missing / np.maximum(length, 1e-12))[:, None] * (end - start)
    return gone > end_length_mm, moved


def _owners(
    start: np.ndarray,
    end: np.ndarray,
    stroke: np.ndarray,
    origin: np.ndarray,
    shape: tuple[int, int],
    line_width_mm: float,
) -> np.ndarray:
    """Return for each pixel the piece that aligned it last, -1 where none did, shape `shape`.

    Pieces follow the scratching order. A pixel within the line of several consecutive pieces of one pass goes to the
    nearest of them; pieces that come back later overwrite.
    """
    half = 0.5 * line_width_mm
    reach = int(np.ceil((half + 0.5 * line_width_mm) / PIXEL_MM)) + 1
    offset = np.arange(-reach, reach + 1)
    centre = np.round((0.5 * (start + end) - origin) / PIXEL_MM).astype(int)
    row = centre[:, 1, None, None] + offset[:, None]
    column = centre[:, 0, None, None] + offset[None, :]
    x = origin[0] + PIXEL_MM * column - start[:, 0, None, None]
    y = origin[1] + PIXEL_MM * row - start[:, 1, None, None]
    along = end - start
    length2 = np.maximum((along**2).sum(axis=1), 1e-12)[:, None, None]
    share = np.clip((x * along[:, 0, None, None] + y * along[:, 1, None, None]) / length2, 0.0, 1.0)
    distance = np.hypot(x - share * along[:, 0, None, None], y - share * along[:, 1, None, None])
    # a hair more than half: pixels midway between two touching lines belong to one of them, whatever the rounding
    inside = (distance <= half + 1e-6) & (row >= 0) & (row < shape[0]) & (column >= 0) & (column < shape[1])
    piece, i, j = np.nonzero(inside)
    pixel = row[piece, i, 0] * shape[1] + column[piece, 0, j]
    # neighbours along a pass share their round ends: a run of consecutive pieces at a pixel is one visit
    order = np.lexsort((piece, pixel))
    pixel, piece, distance = pixel[order], piece[order], distance[piece, i, j][order]
    new_visit = np.ones(len(pixel), dtype=bool)
    new_visit[1:] = (np.diff(pixel) != 0) | (np.diff(piece) > 1) | (np.diff(stroke[piece]) > 0)
    visit = np.cumsum(new_visit)
    best = np.lexsort((-distance, visit))
    owner = np.full(shape[0] * shape[1], -1)
    # fancy assignment keeps the last value: the nearest piece of the last visit
    owner[pixel[best]] = piece[best]
    return owner.reshape(shape)
