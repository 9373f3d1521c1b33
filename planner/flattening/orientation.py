"""Orientation of the flat film: no folded triangle, no rotation against the target, no reflection."""

import numpy as np


def signed_double_areas(film_mm: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Twice the signed area of each triangle [mm2], shape [m]; positive = counter-clockwise."""
    first = film_mm[triangles[:, 1]] - film_mm[triangles[:, 0]]
    second = film_mm[triangles[:, 2]] - film_mm[triangles[:, 0]]
    return first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]


def place_upright(film_mm: np.ndarray, seen_from_above_mm: np.ndarray) -> np.ndarray:
    """Rotate and translate the film [mm], shape [n, 2], onto the surface seen from above, never scaled or mirrored.

    The rotation is the least-squares one (Procrustes); in two dimensions it is the argument of a complex sum.
    """
    film = film_mm - film_mm.mean(axis=0)
    reference = seen_from_above_mm - seen_from_above_mm.mean(axis=0)
    turn = np.vdot(film[:, 0] + 1j * film[:, 1], reference[:, 0] + 1j * reference[:, 1])
    cosine, sine = turn.real / abs(turn), turn.imag / abs(turn)
    rotation = np.array([[cosine, -sine], [sine, cosine]])
    return film @ rotation.T + seen_from_above_mm.mean(axis=0)
