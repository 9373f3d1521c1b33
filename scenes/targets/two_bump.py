"""Two bumps side by side, one convex and one concave."""

import numpy as np

from planner.target import Target, target_from_heights
from scenes.targets.grid import bump, centred_grid


def two_bump(*, width_mm: float, height_mm: float, bump_mm: float, spread_mm: float) -> Target:
    """Make a flat ellipse with a dome on its left and a hollow on its right.

    Args:
        width_mm: Width of the elliptic outline [mm].
        height_mm: Height of the elliptic outline [mm].
        bump_mm: Height of the dome and depth of the hollow [mm].
        spread_mm: Distance over which each falls to 1/e [mm].
    """
    x_mm, y_mm = centred_grid(width_mm, height_mm)
    X, Y = np.meshgrid(x_mm, y_mm)
    at, radii = width_mm / 4.5, (spread_mm, spread_mm)
    z = bump(X, Y, at=(-at, 0.0), radii=radii, height=bump_mm) + bump(X, Y, at=(at, 0.0), radii=radii, height=-bump_mm)
    inside = (2 * X / width_mm) ** 2 + (2 * Y / height_mm) ** 2 <= 1.0
    return target_from_heights("two bumps", x_mm, y_mm, np.where(inside, z, np.nan))
