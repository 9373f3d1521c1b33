"""Trimmed point-to-plane ICP between two surfaces, with pairs made both ways."""

import numpy as np
from scipy.spatial.transform import Rotation

from twin.scan.closest import ClosestPoints
from twin.scan.rigid import RigidTransform

_SLIDE_WEIGHT = 0.02
"""Weight of the tangential part of each pair's squared distance. It holds what the planes leave free (the yaw of
a dome) and pulls rims together; small, so that the fit remains point-to-plane."""
_LARGEST_TURN_RAD = 0.3
"""Largest rotation in one step, since the step is linearised."""
_CONVERGED_MM = 1e-5
"""A step that moves no point farther than this ends the iteration."""


class TrimmedIcp:
    """Iterative closest points from a shape to a goal, six degrees of freedom, no scale, no reflection.

    Pairs are made both ways, from the shape to the goal and from the goal to the shape: a film that is too
    shallow would otherwise slide under a wall of the goal, where all *its* points find something near while the
    rest of the goal is left alone. The share of pairs kept is chosen in each step, each way, as in trimmed ICP
    (Chetverikov et al. 2005, doi 10.1016/j.imavis.2004.05.007): the least mean square over share^3. A shape that
    misses evenly keeps all of its pairs; a gap in a good scan is left out.
    """

    def __init__(self, shape: ClosestPoints, goal: ClosestPoints, *, samples: int, overlap: float) -> None:
        """Sample both surfaces.

        Args:
            shape: Surface to move, triangles or cloud.
            goal: Surface to lay it over, triangles.
            samples: Points on each surface from which pairs are made.
            overlap: Smallest share of pairs to keep, 0..1.
        """
        vectors = goal.area_vectors
        self._normals = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-300)
        self._shape, self._goal, self._overlap = shape, goal, overlap
        self._shape_points, _ = shape.sample(samples)
        self._goal_points, on = goal.sample(samples)
        self._goal_normals = self._normals[on]

    def descend(self, start: RigidTransform, steps: int) -> RigidTransform:
        """Improve a start by at most `steps` steps; the best motion seen, with its trimmed residual."""
        rotation, translation = start.rotation, start.translation_mm
        best: RigidTransform | None = None
        for step in range(steps + 1):
            points, goals, normals, residual = self._pairs(rotation, translation)
            if best is None or residual < best.residual_mm:
                best = RigidTransform(rotation=rotation, translation_mm=translation, residual_mm=residual)
            if step == steps:
                break
            turn, centre, shift = _step(points, goals, normals)
            moved = turn @ (translation - centre) + centre + shift
            change = np.abs(turn @ rotation - rotation).max() * np.ptp(points, axis=0).max()
            change += np.abs(moved - translation).max()
            rotation, translation = turn @ rotation, moved
            if change < _CONVERGED_MM:
                break
        assert best is not None
        return best

    def _pairs(self, rotation: np.ndarray, translation: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
        """Kept pairs: moved shape points, goal points, goal normals, each [k, 3]; and the trimmed residual [mm]."""
        moved = self._shape_points @ rotation.T + translation
        closest, out, on = self._goal.find(moved)
        # The shape's tree is not moved: the goal's points go into the shape's frame instead.
        found, back, _ = self._shape.find((self._goal_points - translation) @ rotation)
        found = found @ rotation.T + translation
        kept_out, square_out = _trim(out, self._overlap)
        kept_back, square_back = _trim(back, self._overlap)
        points = np.concatenate([moved[kept_out], found[kept_back]])
        goals = np.concatenate([closest[kept_out], self._goal_points[kept_back]])
        normals = np.concatenate([self._normals[on[kept_out]], self._goal_normals[kept_back]])
        return points, goals, normals, float(np.sqrt((square_out + square_back) / 2.0))


def _trim(distance: np.ndarray, overlap: float) -> tuple[np.ndarray, float]:
    """Indices of the pairs to keep, and their mean square over share^3 [mm2]."""
    order = np.argsort(distance, kind="stable")
    count = np.arange(1, len(order) + 1)
    merit = np.cumsum(distance[order] ** 2) / count / (count / len(order)) ** 3
    fewest = max(int(np.ceil(overlap * len(order))) - 1, 0)
    keep = fewest + int(np.argmin(merit[fewest:]))
    return order[: keep + 1], float(merit[keep])


def _step(points: np.ndarray, goals: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Solve the linearised least squares: rotation [3, 3] about a centre [3], then a shift [3] [mm]."""
    centre = points.mean(axis=0)
    arm, gap = points - centre, goals - points
    # p' = p + w x arm + t. Rows: the normal part, and the three components with the small slide weight.
    normal_rows = np.concatenate([np.cross(arm, normals), normals], axis=1)
    matrix = normal_rows.T @ normal_rows
    vector = normal_rows.T @ np.einsum("ij,ij->i", normals, gap)
    cross = np.zeros((len(arm), 3, 3))
    cross[:, 0, 1], cross[:, 0, 2] = arm[:, 2], -arm[:, 1]
    cross[:, 1, 0], cross[:, 1, 2] = -arm[:, 2], arm[:, 0]
    cross[:, 2, 0], cross[:, 2, 1] = arm[:, 1], -arm[:, 0]
    rows = np.concatenate([cross, np.broadcast_to(np.eye(3), cross.shape)], axis=2).reshape(-1, 6)
    matrix += _SLIDE_WEIGHT * rows.T @ rows
    vector += _SLIDE_WEIGHT * rows.T @ gap.reshape(-1)
    solution = np.linalg.lstsq(matrix, vector, rcond=None)[0]
    turn, shift = solution[:3], solution[3:]
    turn = turn * min(1.0, _LARGEST_TURN_RAD / max(float(np.linalg.norm(turn)), 1e-300))
    return Rotation.from_rotvec(turn).as_matrix(), centre, shift
