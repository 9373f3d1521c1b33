"""The grid under every parametric target, and the few smooth shapes that they are built from."""

import numpy as np

WIDEST_STEP_MM = 0.25
"""Largest distance between grid nodes [mm]."""
FEWEST_CELLS = 100
"""Grid cells across the shorter side at least, so that the outlines of small targets stay true."""


def centred_grid(width_mm: float, height_mm: float) -> tuple[np.ndarray, np.ndarray]:
    """Node coordinates [mm] of a grid centred at 0 with a node there, one step wider than the box, [nx], [ny]."""
    step = min(WIDEST_STEP_MM, min(width_mm, height_mm) / FEWEST_CELLS)
    x, y = (
        step * np.arange(-count, count + 1)
        for count in (int(np.ceil(size / 2.0 / step)) + 1 for size in (width_mm, height_mm))
    )
    return x, y


def bump(
    X: np.ndarray,
    Y: np.ndarray,
    *,
    at: tuple[float, float],
    radii: tuple[float, float],
    height: float,
    tilt_rad: float = 0.0,
) -> np.ndarray:
    """Smooth elliptic dome height exp(-u^2 - v^2), where u, v are distances along its axes over its radii.

    Its curvature at the top is 2 height / radius^2. A negative height makes a hollow. All lengths in one unit.
    """
    dx, dy = X - at[0], Y - at[1]
    along = (np.cos(tilt_rad) * dx + np.sin(tilt_rad) * dy) / radii[0]
    across = (np.cos(tilt_rad) * dy - np.sin(tilt_rad) * dx) / radii[1]
    return height * np.exp(-(along**2) - across**2)


def smooth_step(x: np.ndarray) -> np.ndarray:
    """Rise from 0 at x <= 0 to 1 at x >= 1 with continuous curvature."""
    t = np.clip(x, 0.0, 1.0)
    return t**3 * (t * (6.0 * t - 15.0) + 10.0)
