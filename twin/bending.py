"""Read a bending radius off a hot film, as one does from a photograph of a calibration strip."""

import numpy as np

from twin.predict import HotShape


PATCH_MM = (2.0, 4.0)
"""Half length along and half width across the line of the patch that is fitted [mm]."""
DEGREE = 6
"""Of the polynomial along the line: a patch may span more than a radian."""


def bending_radius_mm(shape: HotShape, *, direction_rad: float = 0.0) -> float:
    """Return the signed radius of curvature of the mid-surface in the middle of the film [mm].

    The positions in a patch around the middle are fitted by polynomials of the flat coordinates; the radius is that
    of the material line through the middle: |x'|^2 / (x'' . n). Positive where the film is convex seen from above.

    Args:
        shape: the heated film.
        direction_rad: direction of the line on the flat film.
    """
    flat = shape.film.flat_mm - 0.5 * (shape.film.flat_mm.min(axis=0) + shape.film.flat_mm.max(axis=0))
    cos, sin = np.cos(direction_rad), np.sin(direction_rad)
    along, across = flat @ (cos, sin), flat @ (-sin, cos)
    near = (np.abs(along) <= PATCH_MM[0]) & (np.abs(across) <= PATCH_MM[1])
    u, v = along[near], across[near]
    terms = np.column_stack([u**n for n in range(DEGREE + 1)] + [v, u * v, u * u * v, v * v, u * v * v])
    fit = np.linalg.lstsq(terms, shape.hot_mm[near], rcond=None)[0]
    tangent, bend, other = fit[1], 2.0 * fit[2], fit[DEGREE + 1]
    normal = np.cross(tangent, other)
    return float(-(tangent @ tangent) * np.linalg.norm(normal) / (bend @ normal))
