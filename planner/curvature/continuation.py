"""Heights that go on beyond the outline, so that searches near it stay well behaved."""

from collections.abc import Callable

import numpy as np
from scipy.ndimage import distance_transform_edt, map_coordinates

from planner.target import Target

Height = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Height z [mm] at x, y [mm], arrays of one shape; finite everywhere."""


def continued_height(target: Target) -> Height:
    """Return the target's bilinear height, continued level beyond the outline from its nearest point.

    A neighbour search passes over the rim and comes back; a cliff or NaN there would lead it astray. Whether the
    neighbour that it found lies within the outline is another question, asked afterwards.
    """
    outside = ~np.isfinite(target.z_mm)
    nearest = np.asarray(distance_transform_edt(outside, return_distances=False, return_indices=True))
    heights = target.z_mm[tuple(nearest)]
    x0, y0 = float(target.x_mm[0]), float(target.y_mm[0])
    dx = float(target.x_mm[-1] - x0) / (len(target.x_mm) - 1)
    dy = float(target.y_mm[-1] - y0) / (len(target.y_mm) - 1)

    def height(x_mm: np.ndarray, y_mm: np.ndarray) -> np.ndarray:
        return map_coordinates(heights, ((y_mm - y0) / dy, (x_mm - x0) / dx), order=1, mode="nearest")

    return height
