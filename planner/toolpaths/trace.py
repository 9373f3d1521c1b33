"""From a cloud of directions to passes of the post (paper, section 2.3, Step 3)."""

from dataclasses import dataclass
from typing import cast

import numpy as np
from scipy.spatial import KDTree

LOST = -1
"""Successor of a point whose next step finds no point to go on to."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TracedPass:
    """One path along the direction field."""

    points_mm: np.ndarray
    """Points on the film [mm], shape [m, 2], float, m >= 2."""
    curvature_per_mm: np.ndarray
    """Signed curvature wanted at the points [1/mm], shape [m], float."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Tracing:
    """All passes of one cloud, and what they leave out."""

    passes: tuple[TracedPass, ...]
    covered: np.ndarray
    """Cloud points within half a line width of a pass, shape [n], bool."""
    dropped: int
    """Number of paths of a single point, which are too short to scratch."""


def trace_passes(
    film_points: np.ndarray,
    direction_rad: np.ndarray,
    curvature: np.ndarray,
    rng: np.random.Generator,
    *,
    step_mm: float = 0.8,
    max_turn_rad: float = np.pi / 6,
    line_width_mm: float = 0.8,
) -> Tracing:
    """Cover a cloud of points with passes that follow its direction field.

    A path starts at a random point and steps both ways along the local direction; each step goes on to the cloud
    point nearest to its end. It stops where the direction turns by more than `max_turn_rad` from one point to the
    next, where no cloud point lies within half a line width of the step's end (a hole or the edge), where that
    point belongs to an earlier path, or where the path meets itself. Then all points within half a line width of
    the path are taken out, until none is left.

           . . . . . . .            o  path point, 0.8 mm apart
          -o---o---o---o-  0.4 mm   .  cloud points that the path takes out
           . . . . . . .

    Args:
        film_points: cloud on the film [mm], shape [n, 2].
        direction_rad: direction at each point, modulo pi [rad], shape [n].
        curvature: signed curvature at each point [1/mm], shape [n]; give convex and concave points separately.
        rng: chooses the starting points.
        step_mm: length of a step [mm].
        max_turn_rad: largest change of direction within a path from one point to the next [rad].
        line_width_mm: width that a pass aligns [mm].

    """
    points = np.ascontiguousarray(film_points, dtype=float).reshape(-1, 2)
    count = len(points)
    covered = np.zeros(count, dtype=bool)
    taken = np.zeros(count, dtype=bool)
    if count == 0:
        return Tracing(passes=(), covered=covered, dropped=0)
    tree = KDTree(points)
    half = line_width_mm / 2
    following = _successors(tree, direction_rad, step_mm, max_turn_rad, half)
    passes, dropped = [], 0
    for start in rng.permutation(count):
        if taken[start]:
            continue
        path = _path(int(start), points, following, taken, half)
        near = _near_path(tree, points[path], half)
        taken[near] = True
        if len(path) == 1:
            dropped += 1
            continue
        covered[near] = True
        passes.append(TracedPass(points_mm=points[path], curvature_per_mm=np.asarray(curvature)[path]))
    return Tracing(passes=tuple(passes), covered=covered, dropped=dropped)


def _successors(
    tree: KDTree, direction_rad: np.ndarray, step_mm: float, max_turn_rad: float, reach_mm: float
) -> np.ndarray:
    """Where a step from each point leads, as walking states, shape [2 n], int.

    State 2 i walks along the direction of point i, state 2 i + 1 against it. Directions are modulo pi: a successor's
    direction may point backwards, and then the walk goes on against it.
    """
    direction = np.asarray(direction_rad, dtype=float)
    ahead = step_mm * np.stack([np.cos(direction), np.sin(direction)], axis=1)
    states = np.full(2 * len(direction), LOST)
    for against, steps in enumerate((ahead, -ahead)):
        found_at = tree.query(tree.data + steps, distance_upper_bound=reach_mm)
        distance, nearest = cast(tuple[np.ndarray, np.ndarray], found_at)
        found = np.flatnonzero(np.isfinite(distance))
        target = nearest[found]
        alignment = np.cos(direction[target] - direction[found])
        smooth = np.abs(alignment) >= np.cos(max_turn_rad) - 1e-12
        turned = (alignment < 0) ^ bool(against)
        states[2 * found[smooth] + against] = (2 * target + turned)[smooth]
    return states


def _path(start: int, points: np.ndarray, following: np.ndarray, taken: np.ndarray, half_mm: float) -> list[int]:
    """Walk both ways from a point; return the indices of the path's points in order."""
    forward = _walk(2 * start, [start], points, following, taken, half_mm)
    closed = forward[0] == forward[-1] and len(forward) > 1
    if closed:
        return forward
    return _walk(2 * start + 1, forward[::-1], points, following, taken, half_mm)


def _walk(
    state: int, path: list[int], points: np.ndarray, following: np.ndarray, taken: np.ndarray, half_mm: float
) -> list[int]:
    """Extend a path at its end, walking from a state of its last point."""
    while True:
        state = int(following[state])
        if state == LOST or taken[state // 2]:
            return path
        candidate = state // 2
        gap = np.linalg.norm(points[path] - points[candidate], axis=1)
        gap[-1] = np.inf
        meeting = int(np.argmin(gap))
        if gap[meeting] <= half_mm:
            # A ring: close it on its own beginning, so that no gap stays between its ends.
            if meeting == 0 and len(path) > 2:
                path.append(path[0])
            return path
        path.append(candidate)


def _near_path(tree: KDTree, path_mm: np.ndarray, half_mm: float) -> np.ndarray:
    """Return the indices of cloud points within a distance of a polyline [mm]; a single point is a disc."""
    begin, end = (path_mm[:-1], path_mm[1:]) if len(path_mm) > 1 else (path_mm, path_mm)
    along = end - begin
    length = np.linalg.norm(along, axis=1)
    balls = tree.query_ball_point((begin + end) / 2, length / 2 + half_mm)
    counts = [len(ball) for ball in balls]
    index = np.concatenate([np.asarray(ball, dtype=int) for ball in balls])
    segment = np.repeat(np.arange(len(begin)), counts)
    offset = np.asarray(tree.data)[index] - begin[segment]
    squared = np.maximum(length**2, 1e-300)[segment]
    share = np.clip(np.einsum("ij,ij->i", offset, along[segment]) / squared, 0, 1)
    distance = np.linalg.norm(offset - share[:, None] * along[segment], axis=1)
    return index[distance <= half_mm]
