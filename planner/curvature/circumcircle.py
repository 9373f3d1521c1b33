"""Curvature of the circle through three points (paper, section 2.3, Eq. 1-3)."""

import numpy as np


def signed_curvature(
    back_mm: np.ndarray, rise_back_mm: np.ndarray, ahead_mm: np.ndarray, rise_ahead_mm: np.ndarray
) -> np.ndarray:
    """Signed curvature 1 / r [1/mm] of the circle through P2, P1, P3 in one vertical plane.

                 P1                        P1 is the origin of the plane;
              ,-'  '-,                     P2 = (-back, rise_back), P3 = (ahead, rise_ahead);
      l1   ,-'        '-,   l2             positive where P1 lies above the chord l3.
         ,'              ',
       P2 - - - - - - - - P3
                l3

    Eq. 3, r = l1 l2 l3 / (4 S), with the actual distances. The area S is half the cross product of the two sides
    rather than Heron's formula (Eq. 2): equal in exact arithmetic, but Heron subtracts nearly equal lengths where
    the points are nearly collinear, and the cross product brings the sign with it.

    Args:
        back_mm: horizontal distance from P1 back to P2 [mm], positive, any shape.
        rise_back_mm: height of P2 above P1 [mm].
        ahead_mm: horizontal distance from P1 ahead to P3 [mm], positive.
        rise_ahead_mm: height of P3 above P1 [mm].
    """
    double_area = -(ahead_mm * rise_back_mm + back_mm * rise_ahead_mm)
    l1 = np.hypot(back_mm, rise_back_mm)
    l2 = np.hypot(ahead_mm, rise_ahead_mm)
    l3 = np.hypot(back_mm + ahead_mm, rise_ahead_mm - rise_back_mm)
    return 2.0 * double_area / (l1 * l2 * l3)
