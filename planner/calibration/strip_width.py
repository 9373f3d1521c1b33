"""How the width of a strip decides how far it bends: an edge that is free to curl takes bending from the length.

A strip that bends along its length wants to curl across it. A narrow one can; a wide one cannot but near its edges,
because curling would stretch it. Plate theory of Lamb (1890) and Ashwell (1950, The anticlastic curvature of
rectangular beams and plates), for Poisson's ratio 1/2: with the curvature k along and the deflection w(y) across,

    w'''' + 4 alpha^4 w = 0,   4 alpha^4 = 12 (1 - nu^2) k^2 / H^2,   w'' = -nu k and w''' = 0 at y = +-W/2

and a strip of one spontaneous curvature bends to R(W) = S R(wide), where, with means over the width,

    S = 1 + nu <w''>/k + (4 alpha^4 / k^2) <w^2>,   from 1 - nu^2 = 3/4 (narrow) to 1 (wide).
"""

import numpy as np
from numpy.typing import ArrayLike

NU = 0.5
LARGEST = 40.0
"""Of alpha W/2, beyond which the edges are too far apart to be told from a wide strip's: S is 1 within 0.7 %."""
POINTS = 200
BISECTIONS = 60


def width_factor(curvature_per_mm: ArrayLike, thickness_mm: float, width_mm: float) -> np.ndarray:
    """Return S, the bending radius of a strip over that of a wide one with the same contraction.

    Args:
        curvature_per_mm: size of the curvature to which the strip of this width bends [1/mm], any shape.
        thickness_mm: thickness of the strip [mm].
        width_mm: its width [mm].

    """
    curvature = np.abs(np.asarray(curvature_per_mm, dtype=float))
    alpha = (3.0 * (1.0 - NU**2)) ** 0.25 * np.sqrt(curvature / thickness_mm)
    half = np.clip(alpha * width_mm / 2.0, 1e-3, LARGEST)[..., None]
    # Divided by cosh(half): the products of hyperbolic functions would overflow for wide strips.
    sin, cos, tanh = np.sin(half), np.cos(half), np.tanh(half)
    even, odd = cos * tanh + sin, cos * tanh - sin
    # w = (k / alpha^2) (a cos cosh + b sin sinh) / cosh(half): a / b from w''' = 0, their scale from w'' = -nu k.
    a, b = odd, even
    scale = -NU / (2.0 * (b * cos - a * sin * tanh))
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    place = half * (nodes + 1.0) / 2.0
    # cosh(place) / cosh(half) and sinh(place) / cosh(half)
    fall = np.exp(place - half) / (1.0 + np.exp(-2.0 * half))
    cosh, sinh = fall * (1.0 + np.exp(-2.0 * place)), fall * (1.0 - np.exp(-2.0 * place))
    deflection = scale * (a * np.cos(place) * cosh + b * np.sin(place) * sinh)
    bending = 2.0 * scale * (b * np.cos(place) * cosh - a * np.sin(place) * sinh)
    mean_bending = (bending * weights).sum(axis=-1) / 2.0
    mean_square = (deflection**2 * weights).sum(axis=-1) / 2.0
    return 1.0 + NU * mean_bending + 4.0 * mean_square


def curvature_at_width(wide_per_mm: ArrayLike, thickness_mm: float, width_mm: float) -> np.ndarray:
    """Return how much a strip bends [1/mm] where a wide one of the same contraction has the curvature `wide_per_mm`."""
    wide = np.abs(np.asarray(wide_per_mm, dtype=float))
    low, high = wide, wide / (1.0 - NU**2)
    for _ in range(BISECTIONS):
        middle = (low + high) / 2.0
        # S grows with curvature, so k S(k) rises and meets the wide strip's curvature once.
        above = middle * width_factor(middle, thickness_mm, width_mm) >= wide
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return (low + high) / 2.0
