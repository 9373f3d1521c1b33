"""Read off a hot film how it is bent, as one does from a photograph: a strip's radius, a film's form as a whole."""

import numpy as np

from twin.film import Film
from twin.predict import HotShape

PATCH_MM = (2.0, 4.0)
"""Half length along and half width across the line of the patch that is fitted [mm]."""
DEGREE = 6
"""Of the polynomial along the line: a patch may span more than a radian."""


def bending_radius_mm(shape: HotShape, *, direction_rad: float = 0.0) -> float:
    """Return the signed radius of curvature of the mid-surface in the middle of the film [mm].

    The positions in a patch around the middle are fitted by polynomials of the flat coordinates; the radius is that
    of the material line through the middle: `|x'|^2 / (x'' . n)`. Positive where the film is convex seen from above.

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


def principal_curvatures_per_mm(film: Film, vertices_mm: np.ndarray) -> np.ndarray:
    """Return the two principal curvatures of a bent film as a whole [1/mm], ascending, shape [2].

    The positions are fitted by one quadratic polynomial of the flat coordinates, by flat area, and the curvatures are
    those of the fit in the film's middle: eigenvalues of the second by the first fundamental form. Positive where
    convex seen from the side of the film's top face: a dome has two positive ones, a saddle one of each sign. Rigid
    motion of the vertices changes nothing.

    Args:
        film: the film.
        vertices_mm: its vertices when bent [mm], shape [n, 3].
    """
    area = film.vertex_area_mm2
    u, v = (film.flat_mm - area @ film.flat_mm / area.sum()).T
    terms = np.column_stack((np.ones_like(u), u, v, 0.5 * u * u, u * v, 0.5 * v * v))
    weight = np.sqrt(area)[:, None]
    _, along, across, uu, uv, vv = np.linalg.lstsq(weight * terms, weight * vertices_mm, rcond=None)[0]
    normal = np.cross(along, across)
    normal /= np.linalg.norm(normal)
    first = np.array([[along @ along, along @ across], [along @ across, across @ across]])
    second = -np.array([[uu @ normal, uv @ normal], [uv @ normal, vv @ normal]])
    return np.sort(np.linalg.eigvals(np.linalg.solve(first, second)).real)
