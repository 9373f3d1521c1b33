"""What keeps a film from its target: where, by how much, why, and what would help."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial import KDTree

from planner.target import Surface, Target
from twin.film import Film
from twin.score import Scored

GOOD_SSIM = 0.95
GOOD_RMS_PERCENT = 0.35
"""Beyond these, RMS distance in percent of the diagonal, a design has not reached its target."""
PATCH_MM = 4.0
"""Radius over which errors are averaged to find the worst place."""
STEEP_DEG = 65.0
AT_THE_LIMIT = 0.95
"""Share of the largest contraction from which alignment counts as being at its limit."""
LARGER = 1.5
THINNER = 1.0 / 1.5
STRONGER = 1.25
HELPS = 0.8
"""A change helps if it leaves less than this share of the energy."""


def describe_limits(
    target: Target,
    scored: Scored,
    film: Film,
    largest: float,
    left_over: Callable[[float, float, float], float] | None,
) -> tuple[str, ...]:
    """Return sentences about a design that does not reach its target; none for one that does.

    Args:
        target: the surface.
        scored: the predicted shape and its errors, vertex by vertex of the film.
        film: the film that was predicted.
        largest: largest contraction that can be scratched.
        left_over: mean energy per thickness of the first design for factors on the target's size, the layers'
            thickness and the largest contraction: what the changes that would help are tried with; None where no time
            is left for that.
    """
    score = scored.score
    if score.ssim_eq4 >= GOOD_SSIM and score.rms_percent_of_diagonal <= GOOD_RMS_PERCENT:
        return ()
    place, mean, worst = _worst_patch(scored)
    near = np.linalg.norm(scored.vertices_mm[film.triangles].mean(axis=1)[:, :2] - place, axis=1) < PATCH_MM
    limited = (film.contraction[:, near] > AT_THE_LIMIT * largest).any(axis=0).mean() if near.any() else 0.0
    slope = np.linalg.norm(np.nan_to_num(Surface(target).gradient(scored.vertices_mm[:, :2])), axis=1)
    here = np.linalg.norm(scored.vertices_mm[:, :2] - place, axis=1) < PATCH_MM
    steepest = float(np.degrees(np.arctan(slope[here].max()))) if here.any() else 0.0
    side = "high" if mean > 0.0 else "low"
    sentences = [
        f"The film does not reach the target (ssim_eq4 {score.ssim_eq4:.3f}, RMS {score.rms_mm:.2f} mm): it is "
        f"farthest off around x = {place[0]:.0f} mm, y = {place[1]:.0f} mm, there {abs(mean):.1f} mm too {side} "
        f"on average and {worst:.1f} mm at most."
    ]
    if limited > 0.1:
        sentences.append(
            f"On {limited:.0%} of that place a layer is scratched with the largest contraction that the calibration "
            f"reaches ({largest:.0%})."
        )
    if steepest > STEEP_DEG:
        sentences.append(
            f"The target is as steep as {steepest:.0f} degrees there: seen from above a small error of place is a "
            "large one of height."
        )
    if left_over is None:
        return (*sentences, "What would help was not looked for: the budget of time was used up.")
    now = left_over(1.0, 1.0, 1.0)
    changes = (
        (f"{LARGER:g} times the size", left_over(LARGER, 1.0, 1.0)),
        (f"layers of {THINNER:.0%} of the thickness", left_over(1.0, THINNER, 1.0)),
        (f"{STRONGER:g} times the largest contraction", left_over(1.0, 1.0, STRONGER)),
    )
    helpful = sorted((energy / now, name) for name, energy in changes if energy < HELPS * now)
    if helpful:
        sentences.append(
            "What would help, by the strain energy that the best flat film keeps at the target: "
            + ", ".join(f"{name} ({share:.0%} of it is left)" for share, name in helpful)
            + "."
        )
    else:
        sentences.append(
            "Neither a larger target, thinner layers nor a wider range of contraction would bring it much nearer: a "
            "simpler or smoother target would."
        )
    return tuple(sentences)


def _worst_patch(scored: Scored) -> tuple[np.ndarray, float, float]:
    """Return the place [mm] where the mean absolute error is largest, the mean and the largest error there [mm]."""
    xy = scored.vertices_mm[:, :2]
    patches = KDTree(xy).query_ball_point(xy, PATCH_MM)
    absolute = np.abs(scored.error_mm)
    centre = int(np.argmax([absolute[patch].mean() for patch in patches]))
    patch = patches[centre]
    return xy[centre], float(scored.error_mm[patch].mean()), float(absolute[patch].max())


def scaled(target: Target, factor: float) -> Target:
    """Return a target of another size, in proportion."""
    return replace(
        target,
        x_mm=factor * target.x_mm,
        y_mm=factor * target.y_mm,
        z_mm=factor * target.z_mm,
        outline_mm=factor * target.outline_mm,
    )
