"""Load and speed for traced passes: load is slow and set for a pass, speed is fast and varies along it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from planner.calibration import Calibration
from planner.program import Pass
from planner.toolpaths.trace import TracedPass

LOAD_LEVELS = 6
"""Their speed ranges overlap by half: a pass mostly finds a level that holds all of its radii."""
TOLERANCE = 0.005
"""Levels whose curvature error is within this share of the wanted curvature are equally good."""
DIGITS = 4
"""Decimals kept in a Program: 0.1 um and 0.1 um/s."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PassSettings:
    """Passes ready for a Program, in the order of the traced ones."""

    passes: tuple[Pass, ...]
    wanted_radius_mm: np.ndarray
    """Bending radius that each segment wants, inside the calibration's range [mm], all passes joined, float."""
    given_radius_mm: np.ndarray
    """Bending radius that load and speed of each segment give [mm], float."""


def set_passes(
    traced: Sequence[TracedPass],
    radius_mm: Sequence[np.ndarray],
    calibration: Calibration,
    side: Literal["convex", "concave"],
) -> PassSettings:
    """Choose one load for each pass and one speed for each of its segments.

    Of a few load levels, each pass takes the one that comes closest to its curvatures (root mean square along its
    length), and among equally good ones the fastest.

    Args:
        traced: the passes.
        radius_mm: for each pass, the bending radius of the calibration strip wanted on its segments [mm], shape
            [m - 1]; values beyond the calibration's range are taken at its ends.
        calibration: the map from load and speed to radius.
        side: which way the passes bend the film.

    """
    if not traced:
        return PassSettings(passes=(), wanted_radius_mm=np.empty(0), given_radius_mm=np.empty(0))
    limits = calibration.record.limits
    owner = np.repeat(np.arange(len(traced)), [len(radii) for radii in radius_mm])
    length = np.concatenate([np.linalg.norm(np.diff(stroke.points_mm, axis=0), axis=1) for stroke in traced])
    wanted = np.clip(np.concatenate(radius_mm), limits.radius_mm_min, limits.radius_mm_max)
    loads = load_levels(calibration)
    chosen = [calibration.settings_for(wanted, load) for load in loads]
    error = np.sqrt([_mean(owner, length, (1 / level.radius_mm - 1 / wanted) ** 2) for level in chosen])
    time = np.array([_mean(owner, length, 1 / level.speed_mm_s) for level in chosen])
    scale = np.sqrt(_mean(owner, length, 1 / wanted**2))
    good = error <= error.min(axis=0) + TOLERANCE * scale
    best = np.argmin(np.where(good, time, np.inf), axis=0)
    speed = np.array([level.speed_mm_s for level in chosen])[best[owner], np.arange(len(owner))]
    speed = np.clip(np.round(speed, DIGITS), limits.speed_mm_s_min, limits.speed_mm_s_max)
    given = np.array([level.radius_mm for level in chosen])[best[owner], np.arange(len(owner))]
    splits = np.cumsum([len(radii) for radii in radius_mm])[:-1]
    passes = tuple(
        Pass(
            points_mm=tuple(map(tuple, np.round(stroke.points_mm, DIGITS).tolist())),
            speed_mm_s=tuple(own.tolist()),
            load_g=(float(loads[level]),),
            side=side,
        )
        for stroke, own, level in zip(traced, np.split(speed, splits), best, strict=True)
    )
    return PassSettings(passes=passes, wanted_radius_mm=wanted, given_radius_mm=given)


def load_levels(calibration: Calibration, count: int = LOAD_LEVELS) -> np.ndarray:
    """Choose loads [g] from the calibration's lightest to its heaviest, at equal ratios of contraction."""
    limits = calibration.record.limits
    fine = np.linspace(limits.load_g_min, limits.load_g_max, 400)
    strength = np.log(calibration.contraction(fine, np.sqrt(limits.speed_mm_s_min * limits.speed_mm_s_max)))
    levels = np.interp(np.linspace(strength[0], strength[-1], count), strength, fine)
    return np.clip(np.round(levels, DIGITS), limits.load_g_min, limits.load_g_max)


def _mean(owner: np.ndarray, length: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Average along each pass, weighted by length, shape [number of passes]."""
    return np.bincount(owner, length * values) / np.bincount(owner, length)
