"""Triangles to grid nodes: every sheet of a mesh above each node."""

from dataclasses import dataclass

import numpy as np

TOUCH_CELLS = 1e-6
"""A node this close to a triangle counts as inside it, so that shared edges leave no gap [cells]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sheets:
    """The sheets of a mesh above the nodes of a grid."""

    top_mm: np.ndarray
    """Height of the highest sheet [mm], NaN where there is none, shape [ny, nx]."""
    count: np.ndarray
    """How many sheets lie above each other, shape [ny, nx], int."""


def rasterise(
    vertices_mm: np.ndarray, triangles: np.ndarray, x_mm: np.ndarray, y_mm: np.ndarray, *, gap_mm: float
) -> Sheets:
    """Find the sheets of a mesh above grid nodes, exactly on its triangles.

    Each triangle is cut by the grid rows it meets and each cut by the columns it meets, so the work grows with
    the covered nodes. Triangles seen edge-on cover nothing.

    Args:
        vertices_mm: Vertices [mm], shape [n, 3].
        triangles: Vertex indices, shape [m, 3].
        x_mm: Grid columns [mm], evenly spaced, shape [nx].
        y_mm: Grid rows [mm], evenly spaced, shape [ny].
        gap_mm: Sheets closer than this count as one [mm].
    """
    nx, ny = len(x_mm), len(y_mm)
    scale = np.array([(nx - 1) / (x_mm[-1] - x_mm[0]), (ny - 1) / (y_mm[-1] - y_mm[0]), 1.0])
    corners = ((vertices_mm - [x_mm[0], y_mm[0], 0.0]) * scale)[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    corners, normal = (array[np.abs(normal[:, 2]) > 1e-12] for array in (corners, normal))

    owner, row = _spans(corners[:, :, 1].min(axis=1), corners[:, :, 1].max(axis=1), ny)
    first, last = _row_intervals(corners[owner], row)
    cut, column = _spans(first, last, nx)
    owner, row = owner[cut], row[cut]

    start, slope = corners[owner, 0], -normal[owner, :2] / normal[owner, 2:]
    z = start[:, 2] + slope[:, 0] * (column - start[:, 0]) + slope[:, 1] * (row - start[:, 1])
    heights = corners[:, :, 2]
    # On steep triangles the rounding of x and y would throw z off the triangle.
    z = np.clip(z, heights.min(axis=1)[owner], heights.max(axis=1)[owner])

    node = row * nx + column
    order = np.lexsort((z, node))
    node, z = node[order], z[order]
    last_of_node = np.append(node[1:] != node[:-1], True)[: node.size]
    top = np.full(nx * ny, np.nan)
    top[node[last_of_node]] = z[last_of_node]
    new_sheet = last_of_node.copy()
    new_sheet[:-1] |= z[1:] - z[:-1] > gap_mm
    count = np.bincount(node[new_sheet], minlength=nx * ny)
    return Sheets(top_mm=top.reshape(ny, nx), count=count.reshape(ny, nx))


def _spans(low: np.ndarray, high: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray]:
    """List the whole numbers within intervals, within 0 .. size - 1: index of the interval, and number."""
    first = np.maximum(np.ceil(low - TOUCH_CELLS), 0).astype(np.int64)
    last = np.minimum(np.floor(high + TOUCH_CELLS), size - 1).astype(np.int64)
    counts = np.maximum(last - first + 1, 0)
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts) + first[owner]


def _row_intervals(corners: np.ndarray, row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cut triangles [k, 3, 3] by one row each [k]: where each cut begins and ends, in columns."""
    first, last = np.full(len(row), np.inf), np.full(len(row), -np.inf)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        start, end = corners[:, a], corners[:, b]
        rise = end[:, 1] - start[:, 1]
        level = np.abs(rise) < TOUCH_CELLS
        along = (row - start[:, 1]) / np.where(level, 1.0, rise)
        met = level & (np.abs(row - start[:, 1]) <= 2 * TOUCH_CELLS)
        met |= ~level & (along > -TOUCH_CELLS / np.abs(np.where(level, 1.0, rise)))
        met &= level | (along < 1.0 + TOUCH_CELLS / np.abs(np.where(level, 1.0, rise)))
        along = np.where(level, 0.0, np.clip(along, 0.0, 1.0))
        at = start[:, 0] + along * (end[:, 0] - start[:, 0])
        other = np.where(level, end[:, 0], at)
        first = np.where(met, np.minimum(first, np.minimum(at, other)), first)
        last = np.where(met, np.maximum(last, np.maximum(at, other)), last)
    missed = last < first
    return np.where(missed, 1.0, first), np.where(missed, 0.0, last)
