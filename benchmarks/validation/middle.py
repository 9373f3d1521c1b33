"""Read the two fundamental forms in the middle of a bent film."""

from dataclasses import dataclass

import numpy as np

DEGREE = 6
"""Along x, where a patch may span more than a radian."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MiddleForms:
    """Forms of the mid-surface in the film's flat frame, at the middle of its bounding box."""

    first: np.ndarray
    """a [1], shape [2, 2]."""
    second: np.ndarray
    """b [1/mm], positive where convex seen from above, shape [2, 2]."""

    @property
    def radius_mm(self) -> float:
        """Signed radius of the material line along x [mm]."""
        return float(self.first[0, 0] / self.second[0, 0])

    @property
    def stretches(self) -> tuple[float, float]:
        """Stretch along x and along y."""
        return float(np.sqrt(self.first[0, 0])), float(np.sqrt(self.first[1, 1]))


def middle_forms(flat_mm: np.ndarray, vertices_mm: np.ndarray, half_mm: tuple[float, float]) -> MiddleForms:
    """Fit the positions in a patch around the middle by polynomials of the flat coordinates.

    Args:
        flat_mm: flat vertices [mm], shape [n, 2].
        vertices_mm: the bent mid-surface [mm], shape [n, 3].
        half_mm: half size of the patch along x and y [mm].
    """
    centred = flat_mm - 0.5 * (flat_mm.min(axis=0) + flat_mm.max(axis=0))
    near = np.all(np.abs(centred) <= half_mm, axis=1)
    u, v = (centred[near] / half_mm).T
    terms = np.column_stack([u**n for n in range(DEGREE + 1)] + [v, u * v, u * u * v, v * v, u * v * v, v**3, v**4])
    fit = np.linalg.lstsq(terms, vertices_mm[near], rcond=None)[0]
    x, y = half_mm
    along, across = fit[1] / x, fit[DEGREE + 1] / y
    bends = np.array(
        [[2.0 * fit[2] / x**2, fit[DEGREE + 2] / (x * y)], [fit[DEGREE + 2] / (x * y), 2.0 * fit[DEGREE + 4] / y**2]]
    )
    normal = np.cross(along, across)
    normal /= np.linalg.norm(normal)
    tangents = np.stack((along, across))
    return MiddleForms(first=tangents @ tangents.T, second=-bends @ normal)
