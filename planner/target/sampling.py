"""Dense sample points on a target's surface."""

import numpy as np
from scipy import ndimage

from planner.errors import InputError
from planner.target.surface import Surface
from planner.target.target import Target

BLOCK_SPACINGS = 2.5
"""Width of the blocks of one pattern [spacings]: wide enough to waste little by rounding the counts up."""


def sample_surface(target: Target, spacing_mm: float = 0.1) -> np.ndarray:
    """Fill the surface with points so that neighbours are at most `spacing_mm` apart (paper, Step 1).

    The grid is cut into blocks of cells, and each block in x and in y into as many parts as its steepest cell
    asks for: steep places get more points. The points follow from the arguments alone, block by block.

    Args:
        target: The surface.
        spacing_mm: Largest distance between neighbours along x and along y, measured on the surface [mm].

    Returns:
        Points on the surface [mm], shape [n, 3].

    Raises:
        InputError: The spacing is not positive.
    """
    if not (np.isfinite(spacing_mm) and spacing_mm > 0):
        raise InputError(f"sampling: the spacing is {spacing_mm} mm; give a positive length, for example 0.1.")
    surface = Surface(target)
    block = max(1, round(BLOCK_SPACINGS * spacing_mm / max(surface.spacing_mm)))
    stretch_x, stretch_y, used = _block_stretch(target, surface, block)
    length = block * np.array(surface.spacing_mm)
    parts_x = np.ceil(stretch_x * length[0] / spacing_mm - 1e-9).astype(int)
    parts_y = np.ceil(stretch_y * length[1] / spacing_mm - 1e-9).astype(int)

    counts = parts_x * parts_y
    owner = np.repeat(np.arange(len(counts)), counts)
    within = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    step_y, step_x = np.divmod(within, parts_x[owner])
    rows, columns = used
    points = np.column_stack(
        (
            target.x_mm[0] + length[0] * (columns[owner] + (step_x + 0.5) / parts_x[owner]),
            target.y_mm[0] + length[1] * (rows[owner] + (step_y + 0.5) / parts_y[owner]),
        )
    )
    points = points[surface.inside(points)]
    return np.column_stack((points, surface.extended_height(points)))


def _block_stretch(
    target: Target, surface: Surface, block: int
) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """Largest length on the surface per length seen from above in each block of cells, along x and along y.

    Returns:
        Stretch along x and along y of the blocks that hold surface, each shape [k], and their rows and columns.
    """
    dx, dy = surface.spacing_mm
    z = surface.extended_height(np.stack(np.meshgrid(target.x_mm, target.y_mm), axis=-1))
    along_x, along_y = np.hypot(np.diff(z, axis=1) / dx, 1.0), np.hypot(np.diff(z, axis=0) / dy, 1.0)
    near = np.array(ndimage.binary_dilation(np.isfinite(target.z_mm), np.ones((3, 3))), dtype=bool)
    cell = near[:-1, :-1] & near[1:, :-1] & near[:-1, 1:] & near[1:, 1:]
    rows, columns = (-(-size // block) for size in cell.shape)
    padding = ((0, rows * block - cell.shape[0]), (0, columns * block - cell.shape[1]))

    def largest(values: np.ndarray) -> np.ndarray:
        tiles = np.pad(np.where(cell, values, 0.0), padding)
        return tiles.reshape(rows, block, columns, block).max(axis=(1, 3))

    stretch_x = largest(np.maximum(along_x[:-1], along_x[1:]))
    stretch_y = largest(np.maximum(along_y[:, :-1], along_y[:, 1:]))
    used = np.nonzero(stretch_x)
    return stretch_x[used], stretch_y[used], (used[0], used[1])
