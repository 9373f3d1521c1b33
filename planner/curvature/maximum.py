"""The direction of largest curvature among 180 orientations."""

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.spatial import KDTree

from planner.curvature.neighbours import neighbour
from planner.curvature.probe import CurvatureProbe, half_turn

ORIENTATIONS = 180
"""Orientations 1 degree apart (paper, section 2.3, Step 1)."""
LATTICE_MM = 0.4
"""Spacing of the lattice on which all orientations are tried [mm]: half a scratched line, a fifth of the arm."""
CLIMB_DEGREES = (8, 4, 2, 1)
"""Turns by which a point betters its neighbours' direction."""
RIM_ORIENTATIONS = 36
"""Orientations tried near the outline; 5 degrees apart the reach of a 2 mm arm is missed by less than 2 um."""


def maximum_directions(probe: CurvatureProbe, points_mm: np.ndarray) -> np.ndarray:
    """Find the direction of largest absolute curvature at points [mm], shape [n, 3] -> [n] [rad].

    All 180 orientations are tried on a lattice only, which is sixteen times sparser than the points. Each point then
    tries the best directions of the four lattice nodes around it, climbs from the best of them in whole degrees, and
    keeps the direction along which its own curvature is largest. So no direction is ever averaged (0 and pi are the
    same line), the jumps where two directions compete stay sharp, and the curvature that a point reports is its own.
    """
    origin = points_mm[:, :2].min(axis=0) - LATTICE_MM / 2
    cell = (points_mm[:, :2] - origin) / LATTICE_MM
    column, row = np.floor(cell).astype(int).T
    best = _lattice_directions(probe, origin, int(column.max()) + 2, int(row.max()) + 2)
    gradient = probe.gradient(points_mm[:, :2])
    chosen = np.zeros(len(points_mm))
    largest = np.full(len(points_mm), -1.0)

    def consider(candidate: np.ndarray) -> None:
        size = np.nan_to_num(abs(probe.curvature(points_mm, gradient, candidate)), nan=-1.0)
        better = size > largest
        chosen[better], largest[better] = candidate[better], size[better]

    for down, right in ((0, 0), (0, 1), (1, 0), (1, 1)):
        consider(best[row + down, column + right])
    for degrees in CLIMB_DEGREES:
        start = chosen.copy()
        consider(half_turn(start + np.deg2rad(degrees)))
        consider(half_turn(start - np.deg2rad(degrees)))
    return chosen


def whole_circle_inside(
    probe: CurvatureProbe, points_mm: np.ndarray, neighbour_mm: float, outline_mm: np.ndarray
) -> np.ndarray:
    """Tell at which points the neighbours of every orientation lie within the outline, shape [n, 3] -> [n], bool."""
    inside = np.ones(len(points_mm), dtype=bool)
    gap = np.linalg.norm(np.diff(outline_mm, axis=0, append=outline_mm[:1]), axis=1).max()
    distance, _ = KDTree(outline_mm).query(points_mm[:, :2], distance_upper_bound=neighbour_mm + gap)
    near = np.flatnonzero(np.isfinite(distance))
    points = points_mm[near]
    for angle in np.arange(2 * RIM_ORIENTATIONS) * np.pi / RIM_ORIENTATIONS:
        way = np.array([np.cos(angle), np.sin(angle)])
        step, _ = neighbour(probe.height, points, np.full(len(near), way[0]), np.full(len(near), way[1]), neighbour_mm)
        inside[near] &= probe.surface.inside(points[:, :2] + step[:, None] * way)
    return inside


def _lattice_directions(probe: CurvatureProbe, origin: np.ndarray, columns: int, rows: int) -> np.ndarray:
    """Directions of largest absolute curvature on a lattice [rad], shape [rows, columns]."""
    x = origin[0] + np.arange(columns) * LATTICE_MM
    y = origin[1] + np.arange(rows) * LATTICE_MM
    xy = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    xy_inside = xy[known := probe.surface.inside(xy)]
    nodes = np.column_stack([xy_inside, probe.height(*xy_inside.T)])
    gradient = probe.gradient(xy_inside)
    best = np.zeros(len(nodes))
    largest = np.full(len(nodes), -1.0)
    for direction in np.arange(ORIENTATIONS) * np.pi / ORIENTATIONS:
        curvature = probe.curvature(nodes, gradient, np.full(len(nodes), direction))
        size = np.nan_to_num(abs(curvature), nan=-1.0)
        better = size > largest
        best[better], largest[better] = direction, size[better]
    # Nodes without an answer (outside, or no orientation with both neighbours) take over their nearest one's.
    answer = np.zeros(len(xy), dtype=bool)
    answer[known] = largest >= 0
    field = np.zeros(len(xy))
    field[known] = best
    answer, field = answer.reshape(rows, columns), field.reshape(rows, columns)
    nearest = np.asarray(distance_transform_edt(~answer, return_distances=False, return_indices=True))
    return field[tuple(nearest)]
