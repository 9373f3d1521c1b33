"""A saddle: up along x, down along y."""

import numpy as np

from planner.target import Target, target_from_heights
from scenes.targets.grid import centred_grid


def saddle(*, radius_mm: float, edge_radius_mm: float) -> Target:
    """Make z = (y^2 - x^2) / (2 radius) within a round outline: convex along x, concave along y.

    Args:
        radius_mm: Radius of both curvatures in the middle [mm].
        edge_radius_mm: Radius of the outline [mm].
    """
    x_mm, y_mm = centred_grid(2 * edge_radius_mm, 2 * edge_radius_mm)
    X, Y = np.meshgrid(x_mm, y_mm)
    inside = edge_radius_mm**2 >= X**2 + Y**2
    return target_from_heights("saddle", x_mm, y_mm, np.where(inside, (Y**2 - X**2) / (2 * radius_mm), np.nan))
