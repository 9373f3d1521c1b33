"""The smooth outline of a region given on a grid."""

import numpy as np
import shapely
from scipy import ndimage
from scipy.spatial import KDTree
from skimage.measure import find_contours

OUTLINE_STEP_MM = 0.25
"""Distance between neighbouring outline points [mm], less on fine grids."""
LOOSENESS_CELLS = 0.55
"""How far smoothing may move the outline [cells]: the half cell left unknown by the grid, and a little."""


def region_outlines(inside: np.ndarray, x_mm: np.ndarray, y_mm: np.ndarray) -> list[np.ndarray]:
    """Trace the outer borders of a region, largest first, smooth to a fraction of a cell.

    The border runs half a cell beyond the last inside nodes, but never beyond the grid. Among the curves
    within half a cell of that border nearly the one of least bending is taken: it has no grid teeth, while
    the corners of a rectangle are rounded by about one cell.

    Args:
        inside: True on nodes of the region, shape [ny, nx].
        x_mm: Grid columns [mm], evenly spaced, ascending, shape [nx].
        y_mm: Grid rows [mm], evenly spaced, ascending, shape [ny].

    Returns:
        Closed outlines [mm], counter-clockwise, first point not repeated, each shape [n, 2].

    """
    pad = 4
    dx, dy = _step(x_mm), _step(y_mm)
    level = ndimage.gaussian_filter(np.pad(inside, pad).astype(float), sigma=0.8)
    low, high = np.array([x_mm[0], y_mm[0]]), np.array([x_mm[-1], y_mm[-1]])
    loops = []
    for contour in find_contours(level, 0.5):
        loop = np.column_stack((x_mm[0] + (contour[:, 1] - pad) * dx, y_mm[0] + (contour[:, 0] - pad) * dy))
        loop = np.clip(loop, low, high)[:-1]
        # find_contours keeps the region on one side: outer borders run counter-clockwise, holes clockwise.
        area = signed_area(loop)
        if area > 0:
            loops.append((area, loop))
    loops.sort(key=lambda item: -item[0])
    return [_unkink(loop, max(dx, dy), low, high) for _, loop in loops]


def signed_area(loop: np.ndarray) -> float:
    """Area enclosed by a closed polyline [unit^2], positive when counter-clockwise; loop has shape [n, 2]."""
    x, y = loop.T
    return 0.5 * float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))


def resample_loop(loop: np.ndarray, count: int) -> np.ndarray:
    """Place `count` points at equal arc length along a closed polyline; loop and result have shape [n, 2]."""
    closed = np.vstack((loop, loop[:1]))
    arc = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))))
    at = arc[-1] * np.arange(count) / count
    return np.column_stack((np.interp(at, arc, closed[:, 0]), np.interp(at, arc, closed[:, 1])))


def loop_length(loop: np.ndarray) -> float:
    """Length of a closed polyline of shape [n, 2]."""
    return float(np.linalg.norm(loop - np.roll(loop, -1, axis=0), axis=1).sum())


def signed_distance(points: np.ndarray, loop: np.ndarray) -> np.ndarray:
    """Distance of points to a finely sampled closed outline [mm], positive inside.

    Args:
        points: Points [mm], shape [n, 2].
        loop: Closed outline [mm], evenly sampled, shape [m, 2].

    """
    nearest = KDTree(loop).query(points)[1]
    distance = np.full(len(points), np.inf)
    for offset in (-1, 0):
        start, end = loop[(nearest + offset) % len(loop)], loop[(nearest + offset + 1) % len(loop)]
        edge = end - start
        along = np.einsum("ij,ij->i", points - start, edge) / np.einsum("ij,ij->i", edge, edge)
        foot = start + np.clip(along, 0.0, 1.0)[:, None] * edge
        distance = np.minimum(distance, np.linalg.norm(points - foot, axis=1))
    within = shapely.contains_xy(shapely.Polygon(loop), points[:, 0], points[:, 1])
    return np.where(within, distance, -distance)


def _unkink(loop: np.ndarray, cell: float, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Straighten the grid's staircase out of a loop, moving no point by more than about half a cell."""
    count = max(64, round(loop_length(loop) / (0.5 * cell)))
    raw = resample_loop(loop, count)
    step = loop_length(raw) / count
    wave = 2.0 * np.pi * np.fft.fftfreq(count, d=step)
    curve = raw
    for stiffness_cells in [12.0] * 40 + [6.0] * 20 + [3.0] * 10 + [1.5] * 5:
        damping = 1.0 / (1.0 + (stiffness_cells * cell * wave) ** 4)
        curve = np.fft.ifft(np.fft.fft(curve, axis=0) * damping[:, None], axis=0).real
        moved = curve - raw
        length = np.linalg.norm(moved, axis=1, keepdims=True)
        curve = raw + moved * np.minimum(1.0, LOOSENESS_CELLS * cell / np.maximum(length, 1e-300))
        curve = np.clip(curve, low, high)
    # Longer steps than a few cells would cut corners that the grid knows.
    return resample_loop(curve, max(64, round(loop_length(curve) / min(OUTLINE_STEP_MM, 2.5 * cell))))


def _step(axis_mm: np.ndarray) -> float:
    return float(axis_mm[-1] - axis_mm[0]) / (len(axis_mm) - 1)
