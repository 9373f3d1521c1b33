"""The score of a shape: registration, depth images, and every number beside each other."""

from dataclasses import dataclass

import numpy as np

from planner.errors import InputError
from planner.target import Target
from twin.scan import (
    ClosestPoints,
    RigidTransform,
    depth_image,
    grey_image,
    grid_points,
    register,
    target_depth_image,
    target_surface,
)
from twin.score.ssim import ssim_eq4, ssim_eq4_inside, ssim_eq4_map, ssim_eq4_own_scale, ssim_gauss

_SAMPLES = 20_000
"""Points on each surface from which distances are measured: about 0.3 mm apart on a face."""


@dataclass(frozen=True, kw_only=True)
class Score:
    """How near a shape comes to its target. Never compare across the variants of the similarity index."""

    ssim_eq4: float
    """Structural similarity by Eq. 4 of the paper, both images in the target's scale: the headline."""
    ssim_eq4_own_scale: float
    """The same after each image is stretched to its own range; hides errors of height."""
    ssim_eq4_inside: float
    """The same as the headline over the windows wholly inside both outlines."""
    ssim_gauss: float
    """Structural similarity with Gaussian windows and constants, background included."""
    rms_mm: float
    """Root mean square distance between the surfaces [mm], both ways, even by area."""
    rms_percent_of_diagonal: float
    """`rms_mm` in percent of the target's bounding box diagonal."""
    hausdorff_mm: float
    """Largest distance between the surfaces [mm], both ways."""
    depth_mm: float
    """Height of the shape's highest above its lowest point [mm], in the target's frame."""
    target_depth_mm: float
    """The same of the target [mm]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Scored:
    """A score with what it was measured on, for pictures and files."""

    score: Score
    transform: RigidTransform
    """The motion that laid the shape over the target."""
    vertices_mm: np.ndarray
    """The shape's vertices in the target's frame [mm], shape [n, 3], float."""
    triangles: np.ndarray
    """Vertex indices, shape [m, 3], int."""
    error_mm: np.ndarray
    """Distance of each vertex from the target [mm], positive above it, shape [n], float."""
    target_depth_mm: np.ndarray
    """Depth image of the target [mm], NaN outside, shape [168, 104], float."""
    shape_depth_mm: np.ndarray
    """Depth image of the shape [mm] over the same box, shape [168, 104], float."""
    ssim_map: np.ndarray
    """Eq. 4 of the window around each pixel, NaN where none counts, shape [168, 104], float."""


def score_surface(
    vertices_mm: np.ndarray,
    triangles: np.ndarray | None,
    target: Target,
    *,
    coarse: bool = False,
) -> Scored:
    """Register a surface to its target and measure it.

    Args:
        vertices_mm: Vertices of the shape's top face, or points of a cloud [mm], shape [n, 3], float.
        triangles: Vertex indices, shape [m, 3], int; None for a cloud, which is triangulated once it lies
            in the target's frame.
        target: The target.
        coarse: The shape's frame is arbitrary, as a scan's; False for predictions.

    Raises:
        InputError: The shape has no finite surface, or lies nowhere above the target's bounding box.
    """
    vertices_mm = np.asarray(vertices_mm, dtype=float)
    if len(vertices_mm) < 3 or not np.isfinite(vertices_mm).all():
        raise InputError(
            f"{target.name}: the shape to score has {len(vertices_mm)} vertices, "
            f"{np.sum(~np.isfinite(vertices_mm).all(axis=-1))} of them not finite; give a finite surface."
        )
    transform = register(vertices_mm, target, triangles=triangles, coarse=coarse)
    moved = transform.apply(vertices_mm)
    if triangles is None:
        moved, triangles = grid_points(moved)
    target_depth = target_depth_image(target)
    shape_depth = depth_image(moved, triangles, target.bounds_mm)
    if np.isnan(shape_depth).all():
        raise InputError(f"{target.name}: the shape lies nowhere over the target; check its units (mm).")
    lowest, highest = float(np.nanmin(target.z_mm)), float(np.nanmax(target.z_mm))
    reference, sample = (grey_image(depth, lowest, highest) for depth in (target_depth, shape_depth))
    rms, largest, error = _distances(ClosestPoints(moved, triangles), target_surface(target))
    score = Score(
        ssim_eq4=ssim_eq4(reference, sample),
        ssim_eq4_own_scale=ssim_eq4_own_scale(reference, sample),
        ssim_eq4_inside=ssim_eq4_inside(reference, sample),
        ssim_gauss=ssim_gauss(reference, sample),
        rms_mm=rms,
        rms_percent_of_diagonal=100.0 * rms / target.diagonal_mm,
        hausdorff_mm=largest,
        depth_mm=float(np.ptp(moved[np.unique(triangles), 2])),
        target_depth_mm=target.depth_mm,
    )
    return Scored(
        score=score,
        transform=transform,
        vertices_mm=moved,
        triangles=triangles,
        error_mm=error,
        target_depth_mm=target_depth,
        shape_depth_mm=shape_depth,
        ssim_map=ssim_eq4_map(reference, sample),
    )


def _distances(shape: ClosestPoints, goal: ClosestPoints) -> tuple[float, float, np.ndarray]:
    """Root mean square and largest distance both ways [mm], and the signed distance of each shape vertex."""
    out = goal.find(shape.sample(_SAMPLES)[0])[1]
    back = shape.find(goal.sample(_SAMPLES)[0])[1]
    rms = np.sqrt((np.mean(out**2) + np.mean(back**2)) / 2.0)
    closest, distance, on = goal.find(shape.vertices_mm)
    above = np.einsum("ij,ij->i", shape.vertices_mm - closest, goal.area_vectors[on]) >= 0
    # The largest distance of a triangle from a surface is nearly always at a corner.
    largest = max(distance.max(), out.max(), back.max())
    return float(rms), float(largest), np.where(above, distance, -distance)
