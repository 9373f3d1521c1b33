"""The paper's grid-block algorithm: tilt each block of the surface flat, then push the blocks apart ring by ring."""

from typing import NamedTuple

import numpy as np
from scipy.ndimage import distance_transform_edt

from planner.target import Surface

POINT_SPACING_MM = 0.1
"""Spacing of the points to which the planes are fitted; the paper's point cloud (section 2.3)."""
SMALLEST_COVER = 0.2
"""A block of which less than this share lies inside the outline takes over its nearest neighbour's plane."""

_CORNERS = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
_CORNER_ROW = np.array([0, 0, 1, 1])
_CORNER_COLUMN = np.array([0, 1, 1, 0])


class BlockPlanes(NamedTuple):
    """Least-squares plane of every block of an x-y grid."""

    origin_mm: np.ndarray
    """Lower left corner of the grid [mm], shape [2]."""
    block_mm: float
    """Side of a block [mm]."""
    slope: np.ndarray
    """Gradient (dz/dx, dz/dy) of each plane, shape [rows, columns, 2]."""
    peak: tuple[int, int]
    """Row and column of the block whose mean height is largest."""


def block_film_positions(
    surface: Surface, bounds_mm: tuple[np.ndarray, np.ndarray], xy_mm: np.ndarray, *, block_mm: float
) -> np.ndarray:
    """Map x-y positions [mm], shape [n, 2], to the film [mm], shape [n, 2] (paper, section 2.3, Step 2, Fig. 5).

    The positions must lie within `bounds_mm` (lower left and upper right corner, each shape [2]).
    """
    planes = fit_planes(surface, bounds_mm, block_mm=block_mm)
    nodes = merge_rings(planes)
    rows, columns = planes.slope.shape[:2]
    cell = (xy_mm - planes.origin_mm) / planes.block_mm
    column = np.clip(np.floor(cell[:, 0]).astype(int), 0, columns - 1)
    row = np.clip(np.floor(cell[:, 1]).astype(int), 0, rows - 1)
    u = (cell[:, 0] - column)[:, None]
    v = (cell[:, 1] - row)[:, None]
    lower = (1 - u) * nodes[row, column] + u * nodes[row, column + 1]
    upper = (1 - u) * nodes[row + 1, column] + u * nodes[row + 1, column + 1]
    return (1 - v) * lower + v * upper


def fit_planes(surface: Surface, bounds_mm: tuple[np.ndarray, np.ndarray], *, block_mm: float) -> BlockPlanes:
    """Fit a least-squares plane to the surface points of each block.

    The grid covers the whole bounding box, so that the rings around the peak are complete for any outline: blocks
    that lie (nearly) outside continue the slope of the nearest block that is covered well enough.
    """
    low, high = bounds_mm
    shape = np.maximum(np.ceil((high - low) / block_mm - 1e-9).astype(int), 1)
    columns, rows = int(shape[0]), int(shape[1])
    origin = (low + high - shape * block_mm) / 2
    side = max(round(block_mm / POINT_SPACING_MM), 4)
    offset = ((np.arange(side) + 0.5) / side - 0.5) * block_mm
    dx, dy = np.meshgrid(offset, offset)
    centre_x = origin[0] + (np.arange(columns) + 0.5) * block_mm
    centre_y = origin[1] + (np.arange(rows) + 0.5) * block_mm
    x = centre_x[None, :, None, None] + dx
    y = centre_y[:, None, None, None] + dy
    x, y = np.broadcast_arrays(x, y)
    z = surface.height(np.column_stack([x.ravel(), y.ravel()])).reshape(rows, columns, side * side)

    seen = np.isfinite(z)
    z = np.where(seen, z, 0.0)
    terms = np.stack([dx.ravel(), dy.ravel(), np.ones(side * side)])
    normal_matrix = np.einsum("rcp,ip,jp->rcij", seen.astype(float), terms, terms)
    moments = np.einsum("rcp,ip->rci", z, terms)
    cover = seen.mean(axis=2)
    good = cover >= SMALLEST_COVER
    if not good.any():
        good = cover == cover.max()
    plane = np.zeros((rows, columns, 3))
    plane[good] = np.linalg.solve(normal_matrix[good], moments[good][..., None])[..., 0]
    mean_height = np.where(good, moments[..., 2] / np.maximum(seen.sum(axis=2), 1), -np.inf)
    peak = np.unravel_index(int(np.argmax(mean_height)), mean_height.shape)
    nearest = distance_transform_edt(~good, return_distances=False, return_indices=True)
    slope = plane[..., :2][tuple(np.asarray(nearest))]
    return BlockPlanes(origin, block_mm, slope, (int(peak[0]), int(peak[1])))


def merge_rings(planes: BlockPlanes) -> np.ndarray:
    """Unroll all blocks and return the film position of every grid node [mm], shape [rows + 1, columns + 1, 2].

    Rings grow from the peak block. A block of a new ring shares two nodes (an edge block) or one node (a corner
    block) with what is already laid out; it is translated until the mid-point of the shared edge, or the shared
    node, coincides. Then every node takes the mean of its position in all blocks laid out so far.

        . . . . .      2 2 2 2 2
        . 1 1 1 .      2 1 1 1 2
        . 1 0 1 .  ->  2 1 0 1 2      0: the peak's block
        . 1 1 1 .      2 1 1 1 2
        . . . . .      2 2 2 2 2
    """
    rows, columns = planes.slope.shape[:2]
    corners = _flat_corners(planes.slope) * planes.block_mm
    row, column = np.indices((rows, columns))
    ring = np.maximum(abs(row - planes.peak[0]), abs(column - planes.peak[1]))
    sums = np.zeros((rows + 1, columns + 1, 2))
    counts = np.zeros((rows + 1, columns + 1))
    for loop in range(int(ring.max()) + 1):
        member = ring == loop
        node = (row[member][:, None] + _CORNER_ROW, column[member][:, None] + _CORNER_COLUMN)
        shape = corners[member]
        if loop == 0:
            placed = shape
        else:
            known = counts[node]
            shared = (known > 0).astype(float)
            gap = sums[node] / np.maximum(known, 1)[..., None] - shape
            shift = (gap * shared[..., None]).sum(axis=1) / shared.sum(axis=1)[:, None]
            placed = shape + shift[:, None]
        np.add.at(sums, node, placed)
        np.add.at(counts, node, 1.0)
    return sums / counts[..., None]


def _flat_corners(slope: np.ndarray) -> np.ndarray:
    """Corners of a unit block after its plane was rotated level about the plane's own horizontal axis.

    Lengths along the horizontal axis stay, lengths along the incline grow by 1 / cos(incline): the paper's
    parallelogram, seen from above once it lies flat.
    """
    squared = (slope**2).sum(axis=-1)
    # (sqrt(1 + g^2) - 1) / g^2, written so that it holds for level blocks as well.
    factor = 1.0 / (np.sqrt(1.0 + squared) + 1.0)
    along = np.einsum("...i,ki->...k", slope, _CORNERS)
    return _CORNERS + factor[..., None, None] * along[..., None] * slope[..., None, :]
