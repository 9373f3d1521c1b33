"""The outline of the flat film."""

import igl
import numpy as np

from planner.flattening.flattening import Flattening


def film_outline(flattening: Flattening) -> np.ndarray:
    """Outline of the flat film [mm], counter-clockwise, first point not repeated, shape [n, 2]."""
    loop = np.asarray(igl.boundary_loop(np.ascontiguousarray(flattening.triangles, dtype=np.int64)))
    return flattening.film_mm[loop]
