"""Rigid registration of a shape to its target: starts, then the trimmed ICP."""

from operator import attrgetter

import numpy as np
from scipy.spatial.transform import Rotation

from planner.target import Target
from twin.scan.closest import ClosestPoints, target_surface
from twin.scan.icp import TrimmedIcp
from twin.scan.rigid import RigidTransform

_YAW_STEPS = 12
_residual = attrgetter("residual_mm")


def register(
    vertices_mm: np.ndarray,
    target: Target,
    *,
    triangles: np.ndarray | None = None,
    coarse: bool = True,
    near: RigidTransform | None = None,
) -> RigidTransform:
    """Find the rigid motion that lays a shape over its target; the same one at each call.

    Args:
        vertices_mm: Vertices of the shape, or points of a cloud [mm], shape [n, 3], float.
        target: The target.
        triangles: Vertex indices of the shape, shape [m, 3], int; None for a cloud.
        coarse: Search all orientations and accept that up to 40 % of the surface is missing, as for scans.
            False for predictions, whose frame is nearly right (shifted, tilted by some 20 degrees).
        near: A motion that is nearly right already, as of the shape a little earlier: the only start then.

    Returns:
        The motion from the shape's frame to the target's.
    """
    shape, goal = ClosestPoints(vertices_mm, triangles), target_surface(target)
    overlap = 0.6 if coarse else 0.9
    many = TrimmedIcp(shape, goal, samples=2500, overlap=overlap)
    if near is not None:
        return many.descend(near, steps=40)
    few = TrimmedIcp(shape, goal, samples=400, overlap=overlap)
    if coarse:
        rough = sorted((few.descend(start, steps=0) for start in _all_starts(shape, goal)), key=_residual)
        rough = sorted((few.descend(start, steps=15) for start in rough[:8]), key=_residual)[:2]
    else:
        rough = [few.descend(start, steps=40) for start in _near_starts(shape, goal)]
    # The residual of a few samples ranks starts that differ clearly; between near equals the many decide.
    best = min((many.descend(start, steps=3) for start in rough), key=_residual)
    return many.descend(best, steps=40)


def _near_starts(shape: ClosestPoints, goal: ClosestPoints) -> list[RigidTransform]:
    """The frame as it is, and with the mean normals of both surfaces made parallel."""
    turns = [np.eye(3)]
    if shape.triangles is not None:
        # The vector area depends on the rim alone, so that it tells the tilt of a shallow shape as well.
        normals = np.stack([surface.area_vectors.sum(axis=0) for surface in (goal, shape)])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        axis = np.cross(normals[1], normals[0])
        sine = float(np.linalg.norm(axis))
        angle = np.arctan2(sine, normals[1] @ normals[0])
        turns.append(Rotation.from_rotvec(axis * angle / max(sine, 1e-300)).as_matrix())
    return _centred(turns, shape, goal)


def _all_starts(shape: ClosestPoints, goal: ClosestPoints) -> list[RigidTransform]:
    """Each principal axis of the shape laid, both ways up, along z, at a dozen yaw angles each."""
    points, _ = shape.sample(2000)
    axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2]
    if np.linalg.det(axes) < 0:
        axes = -axes
    ups = [np.roll(np.eye(3), shift, axis=0) for shift in range(3)]
    flips = [np.eye(3), np.diag([1.0, -1.0, -1.0])]
    yaws = Rotation.from_rotvec(np.outer(np.arange(_YAW_STEPS) * 2.0 * np.pi / _YAW_STEPS, (0, 0, 1))).as_matrix()
    turns = [yaw @ flip @ up @ axes for up in ups for flip in flips for yaw in yaws]
    return _centred([np.eye(3), *turns], shape, goal)


def _centred(turns: list[np.ndarray], shape: ClosestPoints, goal: ClosestPoints) -> list[RigidTransform]:
    """The motions with these rotations that lay one centroid on the other."""
    middle, goal_middle = (surface.sample(2000)[0].mean(axis=0) for surface in (shape, goal))
    return [
        RigidTransform(rotation=turn, translation_mm=goal_middle - turn @ middle, residual_mm=float("inf"))
        for turn in turns
    ]
