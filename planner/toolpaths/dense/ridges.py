"""The ridges of a stripe pattern as polylines."""

import numpy as np
import shapely
from scipy.ndimage import gaussian_filter
from scipy.spatial import KDTree

from planner.toolpaths.dense.grid import CELLS_PER_LINE, FieldGrid
from planner.toolpaths.dense.stripes import Stripes

SMOOTHING_LINES = 0.5
"""Standard deviation, in lines' widths, of the mean over which the stripes' own direction is measured."""
LEAST_HEIGHT = 0.02
"""Ridges lower than this (stripes at rest are about 0.6 high) are remains of noise."""

BREAK_LINES = 0.6
"""Ridges are joined over gaps up to this long, in line widths."""
LEAST_FACING = 0.5
"""Least cosine between the end of a joined ridge and the bridge."""
LOOK_BACK = 3
"""Points over which the direction of a ridge's end is taken."""
SHORTEST_POINTS = LOOK_BACK + 3

Corner = tuple[slice, slice]


def ridge_lines(grid: FieldGrid, pattern: Stripes) -> list[np.ndarray]:
    """Trace the ridges, where the slope across the stripes vanishes at a positive height.

    The direction across has no sign. Marching squares need one only along each edge of the grid: there the normals
    at both ends are turned to agree, so the same crossing is found from both cells that share the edge. Cells with two
    crossed edges give a segment; others lie at a ridge's end, which is a dislocation of the pattern.

    Returns:
        Polylines [mm], shapes [k, 2]; rings repeat their first point.

    """
    gx, gy = pattern.slope
    smoothing = SMOOTHING_LINES * CELLS_PER_LINE
    twice = np.arctan2(gaussian_filter(2 * gx * gy, smoothing), gaussian_filter(gx**2 - gy**2, smoothing))
    across = np.stack([np.cos(twice / 2), np.sin(twice / 2)])
    slope = across[0] * gx + across[1] * gy

    def crossings(first: Corner, second: Corner) -> tuple[np.ndarray, np.ndarray]:
        agree = np.where((across[:, *first] * across[:, *second]).sum(axis=0) < 0, -1.0, 1.0)
        begin, end = slope[first], agree * slope[second]
        crossed = begin * end < 0
        share = begin / np.where(crossed, begin - end, 1.0)
        height = (1 - share) * pattern.height[first] + share * pattern.height[second]
        return crossed & (height > LEAST_HEIGHT), share

    whole, but_last, but_first = slice(None), slice(None, -1), slice(1, None)
    low_edge, along_x = crossings((but_last, whole), (but_first, whole))
    left_edge, along_y = crossings((whole, but_last), (whole, but_first))
    crossed = np.stack([low_edge[:, :-1], left_edge[1:], low_edge[:, 1:], left_edge[:-1]], axis=-1)
    i, j = np.nonzero(crossed.sum(axis=-1) == 2)
    corner = np.stack([i, j], axis=-1)
    low, high, left, right = along_x[i, j], along_x[i, j + 1], along_y[i, j], along_y[i + 1, j]
    zero, one = np.zeros(len(i)), np.ones(len(i))
    places = np.stack(
        [np.stack(pair, axis=-1) for pair in ((low, zero), (one, right), (high, one), (zero, left))], axis=1
    )
    # Equal crossings of neighbouring cells must be equal numbers: rounded before they are scaled to mm.
    segments = np.round(corner[:, None] + places, 6)[crossed[i, j]].reshape(-1, 2, 2)
    return [grid.origin_mm + grid.cell_mm * line for line in _linked(_merged(list(segments)))]


def _merged(pieces: list[np.ndarray]) -> list[np.ndarray]:
    """Join pieces that share an end, where no third does."""
    parts = shapely.get_parts(shapely.line_merge(shapely.MultiLineString(pieces)))
    return [shapely.get_coordinates(line) for line in parts if not line.is_empty]


def _linked(lines: list[np.ndarray]) -> list[np.ndarray]:
    """Bridge breaks: at a dislocation one of two ridges goes on as the third, and single cells may lack a segment."""
    rings = [line for line in lines if np.array_equal(line[0], line[-1])]
    # Three ridges may share their last point: without it each end is its own.
    loose = [line[1:-1] for line in lines if len(line) >= SHORTEST_POINTS and not np.array_equal(line[0], line[-1])]
    if not loose:
        return rings
    ends = np.concatenate([line[[0, -1]] for line in loose])
    ahead = np.concatenate([line[[0, -1]] - line[[LOOK_BACK, -1 - LOOK_BACK]] for line in loose])
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-12)
    first, second = KDTree(ends).query_pairs(BREAK_LINES * CELLS_PER_LINE, output_type="ndarray").T
    across = ends[second] - ends[first]
    gap = np.maximum(np.linalg.norm(across, axis=1), 1e-12)
    facing = np.minimum((ahead[first] * across).sum(axis=1), -(ahead[second] * across).sum(axis=1)) / gap
    links, used = [], set[int]()
    for pair in np.argsort(-facing):
        both = int(first[pair]), int(second[pair])
        if facing[pair] > LEAST_FACING and not used.intersection(both):
            used.update(both)
            links.append(ends[list(both)])
    return [*rings, *_merged([*loose, *links])]
