"""Signed curvature along chosen directions at sample points of the target."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True, eq=False)
class CurvatureField:
    """What Step 1 of the paper leaves for Step 2: at each kept sample point a direction and a curvature."""

    method: str
    """`perpendicular` or `maximum`."""
    points_mm: np.ndarray
    """Sample points on the surface [mm], shape [n, 3], float."""
    direction_rad: np.ndarray
    """Direction of the curvature seen from above, angle from +x in [0, pi) [rad], shape [n], float."""
    curvature_per_mm: np.ndarray
    """Signed curvature [1/mm], positive = convex seen from above (a dome), shape [n], float."""
    dropped_share: float
    """Share of sample points left out because a neighbour lay beyond the outline (0..1)."""
