"""Heights that go on beyond the outline, so that searches near it stay well behaved."""

from collections.abc import Callable

import numpy as np
from scipy.ndimage import binary_dilation, distance_transform_edt, map_coordinates

from planner.target import Surface, Target

Height = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Height z [mm] at x, y [mm], arrays of one shape; finite everywhere."""

RIM_CELLS = 2
"""Grid cells beyond the last known node over which the surface is continued by planes, so that the curvature is right
up to the outline, which runs about half a cell beyond that node."""


def continued_height(target: Target, surface: Surface) -> Height:
    """Return the target's bilinear height, continued level far beyond the outline from its nearest point.

    A neighbour search passes over the rim and comes back; a cliff or NaN there would lead it astray. Whether the
    neighbour that it found lies within the outline is another question, asked afterwards.
    """
    near = np.asarray(binary_dilation(np.isfinite(target.z_mm), iterations=RIM_CELLS), dtype=bool)
    nodes = np.stack(np.meshgrid(target.x_mm, target.y_mm), axis=-1)
    nearest = np.asarray(distance_transform_edt(np.logical_not(near), return_distances=False, return_indices=True))
    heights = surface.extended_height(nodes)[tuple(nearest)]
    x0, y0 = float(target.x_mm[0]), float(target.y_mm[0])
    dx, dy = surface.spacing_mm

    def height(x_mm: np.ndarray, y_mm: np.ndarray) -> np.ndarray:
        return map_coordinates(heights, ((y_mm - y0) / dy, (x_mm - x0) / dx), order=1, mode="nearest")

    return height
