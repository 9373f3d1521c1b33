"""The ridges of a stripe pattern as polylines."""

import numpy as np
import shapely
from scipy.ndimage import gaussian_filter

from planner.toolpaths.dense.grid import CELLS_PER_LINE, FieldGrid
from planner.toolpaths.dense.stripes import Stripes

SMOOTHING_LINES = 0.5
"""Standard deviation, in lines' widths, of the mean over which the stripes' own direction is measured."""
LEAST_HEIGHT = 0.02
"""Ridges lower than this (stripes at rest are about 0.6 high) are remains of noise."""

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
    merged = shapely.line_merge(shapely.MultiLineString(list(segments)))
    return [
        grid.origin_mm + grid.cell_mm * shapely.get_coordinates(line)
        for line in shapely.get_parts(merged)
        if not line.is_empty
    ]
