"""Domes: half an ellipsoid of revolution, oblate or prolate, and the cap of a sphere."""

import numpy as np

from planner.target import Target, target_from_heights
from scenes.targets.grid import centred_grid


def ellipsoid_dome(*, radius_mm: float, height_mm: float, cut: float, name: str = "dome") -> Target:
    """Make the upper half of an ellipsoid of revolution, cut by an upright cylinder.

    z = height sqrt(1 - (r / radius)^2) for r <= cut radius; oblate where height < radius, else prolate.

    Args:
        radius_mm: Radius of the ellipsoid's equator [mm].
        height_mm: Height of the pole above the equator [mm].
        cut: Radius of the outline over `radius_mm`, below 1, where the wall is upright.
        name: Name of the target.
    """
    edge = cut * radius_mm
    x_mm, y_mm = centred_grid(2 * edge, 2 * edge)
    r2 = x_mm[None, :] ** 2 + y_mm[:, None] ** 2
    z = height_mm * np.sqrt(np.maximum(1.0 - r2 / radius_mm**2, 0.0))
    return target_from_heights(name, x_mm, y_mm, np.where(r2 <= edge**2, z, np.nan))


def sphere_cap(*, radius_mm: float, edge_radius_mm: float, name: str = "sphere cap") -> Target:
    """Make the cap of a sphere [mm] with a round outline of radius `edge_radius_mm` [mm]."""
    return ellipsoid_dome(radius_mm=radius_mm, height_mm=radius_mm, cut=edge_radius_mm / radius_mm, name=name)
