"""A ridge: a part of a cylinder with soft ends."""

import numpy as np

from planner.target import Target, target_from_heights
from scenes.targets.grid import centred_grid, smooth_step


def ridge(*, radius_mm: float, width_mm: float, length_mm: float, end_mm: float) -> Target:
    """Make a cylinder's back along y that sinks softly to a fifth of its height at both ends.

    Args:
        radius_mm: Radius of the cylinder [mm].
        width_mm: Width of the outline across the back [mm], below twice the radius.
        length_mm: Length along the back [mm].
        end_mm: Length of each end over which the back sinks [mm].
    """
    x_mm, y_mm = centred_grid(width_mm, length_mm)
    X, Y = np.meshgrid(x_mm, y_mm)
    edge = np.sqrt(radius_mm**2 - (width_mm / 2) ** 2)
    back = np.sqrt(np.maximum(radius_mm**2 - X**2, edge**2)) - edge
    z = back * (0.2 + 0.8 * smooth_step((length_mm / 2 - np.abs(Y)) / end_mm))
    inside = (np.abs(X) <= width_mm / 2) & (np.abs(Y) <= length_mm / 2)
    return target_from_heights("ridge", x_mm, y_mm, np.where(inside, z, np.nan))
