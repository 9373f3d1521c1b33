"""Fewer grid nodes for heights that are finer than anything a film can show."""

import numpy as np

from planner.target.mesh_heights import MOST_COLUMNS


def coarsen(x_mm: np.ndarray, y_mm: np.ndarray, z_mm: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Average blocks of nodes until the grid has at most MOST_COLUMNS columns and rows.

    A block is part of the surface when at least half of its nodes are.

    Args:
        x_mm: Grid columns [mm], shape [nx].
        y_mm: Grid rows [mm], shape [ny].
        z_mm: Heights [mm], NaN outside, shape [ny, nx].
    """
    block = -(-max(z_mm.shape) // MOST_COLUMNS)
    if block == 1:
        return x_mm, y_mm, z_mm
    rows, columns = (size // block for size in z_mm.shape)
    tiles = z_mm[: rows * block, : columns * block].reshape(rows, block, columns, block).swapaxes(1, 2)
    tiles = tiles.reshape(rows, columns, block * block)
    present = np.isfinite(tiles)
    count = present.sum(axis=2)
    total = np.where(present, tiles, 0.0).sum(axis=2)
    z = np.where(2 * count >= block * block, total / np.maximum(count, 1), np.nan)
    x, y = (axis[: size * block].reshape(size, block).mean(axis=1) for axis, size in ((x_mm, columns), (y_mm, rows)))
    return x, y, z
