"""Passes of one width that tile what is to be scratched."""

import numpy as np
from scipy.ndimage import gaussian_filter1d

from planner.errors import InputError
from planner.toolpaths.dense.director_field import DirectorField
from planner.toolpaths.dense.grid import FieldGrid, field_grid
from planner.toolpaths.dense.polyline import length_mm, spaced
from planner.toolpaths.dense.ridges import ridge_lines
from planner.toolpaths.dense.stripes import stripes

LEAST = 0.02
"""Contraction below which film is left unaligned."""
FINE_LINES = 0.125
"""Distance between the points of a line while it is worked on, in line widths."""
SMOOTHING_LINES = 0.3
"""Standard deviation of the smoothing along a line, in line widths: rounds the grid's steps and kinks."""
RELIEF_LINES = 0.125
"""Lines that end inside the region end this much earlier, in line widths: their round ends meet their neighbours."""
STEP_LINES = 0.5
"""Distance between the points of a finished line, in line widths."""
SHORTEST_LINES = 1.0
"""Shorter lines, in line widths, are left out."""


def dense_lines(
    field: DirectorField, *, line_width_mm: float = 0.8, least: float = LEAST, seed: int = 0
) -> list[np.ndarray]:
    """Cover the film where `|q|` >= `least` with lines along the director, one width apart.

    Args:
        field: what the film should be; `MeshField(points_mm=..., triangles=..., q=...)` on the flat film's mesh.
        line_width_mm: width that a pass aligns [mm].
        least: strength `|q|` below which nothing is scratched.
        seed: of the noise that the lines grow from.

    Returns:
        Polylines [mm], shapes [k, 2]; rings repeat their first point.

    Raises:
        InputError: for a width that is not positive.

    """
    if not (np.isfinite(line_width_mm) and line_width_mm > 0):
        raise InputError(f"line_width_mm is {line_width_mm}, allowed is a positive length in mm; give 0.8")
    grid = field_grid(field, line_width_mm, least)
    if not np.isfinite(grid.outside_mm).any():
        return []
    lines = []
    for ridge in ridge_lines(grid, stripes(grid, line_width_mm, seed)):
        parts = _kept(_smoothed(ridge, line_width_mm), grid, line_width_mm)
        lines += [spaced(part, STEP_LINES * line_width_mm) for part in parts]
    return [line for line in lines if length_mm(line) >= SHORTEST_LINES * line_width_mm]


def _kept(line: np.ndarray, grid: FieldGrid, width: float) -> list[np.ndarray]:
    """Cut a line to the wanted region; beyond the film's edge it may run on by a quarter of its width.

    A line beside the border stays while it is less than a quarter of its width outside; one that crosses the border
    ends an eighth outside, for its round end reaches further.
    """
    if len(line) < 2:
        return []
    outside = grid.read(grid.outside_mm, line) - np.minimum(grid.read(grid.beyond_film_mm, line), width / 4)
    inside = outside < width / 4
    if np.array_equal(line[0], line[-1]):
        if inside.all():
            return [line]
        turn = int(np.argmin(inside[:-1]))
        line, outside, inside = (np.roll(values[:-1], -turn, axis=0) for values in (line, outside, inside))
    crossing = outside > width / 8
    most = round(0.25 / FINE_LINES)
    parts = []
    for begin, end in np.flatnonzero(np.diff(np.concatenate([[0], inside.astype(int), [0]]))).reshape(-1, 2):
        ahead, behind = crossing[begin : begin + most], crossing[max(begin, end - most) : end][::-1]
        part = line[begin + int(np.cumprod(ahead).sum()) : end - int(np.cumprod(behind).sum())]
        if len(part) > 1:
            parts.append(part)
    return parts


def _smoothed(line: np.ndarray, width: float) -> np.ndarray:
    """Round a ridge, and shorten it at both ends unless it is a ring; what is too short becomes empty."""
    fine = spaced(line, FINE_LINES * width)
    sigma = SMOOTHING_LINES / FINE_LINES
    if np.array_equal(line[0], line[-1]):
        ring = gaussian_filter1d(fine[:-1], sigma, axis=0, mode="wrap")
        return np.vstack([ring, ring[:1]])
    relief = round(RELIEF_LINES / FINE_LINES)
    return gaussian_filter1d(fine, sigma, axis=0, mode="nearest")[relief : len(fine) - relief]
