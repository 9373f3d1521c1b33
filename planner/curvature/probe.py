"""Curvature of a surface at given points along given directions."""

from typing import Literal

import numpy as np

from planner.curvature.circumcircle import signed_curvature
from planner.curvature.continuation import continued_height
from planner.curvature.neighbours import neighbour
from planner.target import Surface, Target

Plane = Literal["vertical", "normal"]

SMOOTHING_MM = 0.5
"""Width (standard deviation) of the window in which the incline is measured [mm].

The window's +-2 widths span the 2 mm of one arm of the circle, and it is about as wide as the 0.8 mm line that follows
the direction: finer changes cannot be scratched. On rough terrain it halves the share of places where the direction
turns by more than 30 degrees within one line width (0.32 to 0.16, against 0.25 mm); on a smooth face it turns 3 % of
the directions by more than 15 degrees, where 1 mm would turn 10 %, most of them at the nose.
"""


class CurvatureProbe:
    """Three-point curvature with neighbours at a fixed distance along the surface.

    Both neighbours are sought in the vertical plane that contains the direction seen from above. `plane` says whose
    curvature is reported:

    - `vertical`: the circle itself, as Eq. 1-3 of the paper give it.
    - `normal`: the surface's normal curvature in that direction, the circle's times the cosine of the angle between
      the vertical plane and the surface normal (Meusnier's theorem). They differ on inclines: on a sphere of radius R
      at incline a, along the contour, the circle has the radius R cos(a), the surface R.

    The paper does not name its plane. Its own face had 3 % of the points sharper than 1.8 mm and 41 % flatter than
    14.4 mm; a mean face of the same size, sampled alike, has 4 % and 47 % with `vertical`, 0.1 % and 57 % with
    `normal`.
    """

    def __init__(self, target: Target, *, neighbour_mm: float, plane: Plane) -> None:
        self.surface = Surface(target)
        self.height = continued_height(target, self.surface)
        self._neighbour_mm = neighbour_mm
        self._plane: Plane = plane

    def gradient(self, xy_mm: np.ndarray) -> np.ndarray:
        """Incline (dz/dx, dz/dy) at the scale of the neighbours, shape [n, 2] -> [n, 2]."""
        return self.surface.gradient(xy_mm, smoothing_mm=SMOOTHING_MM)

    def contour_direction(self, gradient: np.ndarray) -> np.ndarray:
        """Horizontal direction across the incline, angle from +x in [0, pi) [rad], shape [n, 2] -> [n]."""
        return half_turn(np.arctan2(gradient[:, 1], gradient[:, 0]) + np.pi / 2)

    def curvature(self, points_mm: np.ndarray, gradient: np.ndarray, direction_rad: np.ndarray) -> np.ndarray:
        """Signed curvature [1/mm] at points [mm], shape [n, 3]; NaN where a neighbour lies beyond the outline."""
        cosine, sine = np.cos(direction_rad), np.sin(direction_rad)
        ahead, rise_ahead = neighbour(self.height, points_mm, cosine, sine, self._neighbour_mm)
        back, rise_back = neighbour(self.height, points_mm, -cosine, -sine, self._neighbour_mm)
        curvature = signed_curvature(back, rise_back, ahead, rise_ahead)
        if self._plane == "normal":
            along = gradient[:, 0] * cosine + gradient[:, 1] * sine
            curvature = curvature * np.sqrt((1 + along**2) / (1 + (gradient**2).sum(axis=1)))
        way = np.stack([cosine, sine], axis=1)
        seen = self.surface.inside(points_mm[:, :2] + ahead[:, None] * way)
        seen &= self.surface.inside(points_mm[:, :2] - back[:, None] * way)
        return np.where(seen, curvature, np.nan)


def half_turn(angle_rad: np.ndarray) -> np.ndarray:
    """Bring angles of lines without arrowhead into [0, pi) [rad]."""
    angle = np.mod(angle_rad, np.pi)
    # A tiny negative angle comes back from the modulo as pi itself.
    return np.where(angle >= np.pi, 0.0, angle)
