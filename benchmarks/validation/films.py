"""Films whose hot shape is known in closed form, and how they are heated."""

from collections.abc import Callable, Sequence

import numpy as np

from planner.target import mesh_outline
from twin.film import Film, film_from_alignment
from twin.predict import HotShape, PredictOptions, heat_film

LAYER_MM = 0.2
LAYERS = 4
THICKNESS_MM = LAYERS * LAYER_MM
BOTTOM, TOP, ALL = (0, 1), (2, 3), (0, 1, 2, 3)
MESH_MM = 0.6
"""The default mesh of `lce predict`."""

Direction = Callable[[np.ndarray], np.ndarray]
"""From centroids [mm], shape [m, 2], to director angles [rad], shape [m]."""


def rectangle(length_mm: float, width_mm: float) -> np.ndarray:
    """Outline of a rectangle around the origin, length along x [mm], shape [4, 2]."""
    x, y = 0.5 * length_mm, 0.5 * width_mm
    return np.array([(-x, -y), (x, -y), (x, y), (-x, y)])


def disc(radius_mm: float, points: int = 720) -> np.ndarray:
    """Outline of a circle around the origin [mm], shape [points, 2]."""
    angle = np.linspace(0.0, 2.0 * np.pi, points, endpoint=False)
    return radius_mm * np.column_stack((np.cos(angle), np.sin(angle)))


def along_x(centre: np.ndarray) -> np.ndarray:
    return np.zeros(len(centre))


def radial(centre: np.ndarray) -> np.ndarray:
    return np.arctan2(centre[:, 1], centre[:, 0])


def azimuthal(centre: np.ndarray) -> np.ndarray:
    return radial(centre) + 0.5 * np.pi


def scratched(
    outline_mm: np.ndarray,
    mesh_mm: float,
    contraction: float,
    *,
    layers: Sequence[int] = BOTTOM,
    direction: Direction = along_x,
    layer_mm: float = LAYER_MM,
) -> Film:
    """Return a film of four layers, some of which contract alike along a field of directions."""
    flat, triangles = mesh_outline(outline_mm, mesh_mm)
    angle = direction(flat[triangles].mean(axis=1))
    q = np.zeros((LAYERS, len(triangles), 2))
    q[list(layers)] = contraction * np.column_stack((np.cos(2.0 * angle), np.sin(2.0 * angle)))
    return film_from_alignment(flat, triangles, q, layer_thickness_mm=np.full(LAYERS, layer_mm))


def heated_free(film: Film) -> HotShape:
    """Heat a film that weighs nothing and touches nothing."""
    return heat_film(film, PredictOptions(support="free", device="cpu"))
