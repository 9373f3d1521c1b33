"""As much of a film's heating as a page can carry: fine meshes and long ramps are thinned out."""

from dataclasses import dataclass
from math import sqrt

import numpy as np
from scipy.spatial import KDTree

from twin.film import coarsen
from twin.hot_shape import HotShape

MOST_TRIANGLES = 24_000
MOST_STATES = 60


@dataclass(frozen=True, kw_only=True, eq=False)
class ThinnedHeating:
    """What is shown of a heating."""

    temperature_c: np.ndarray
    """Temperature of the plate at each state that is kept [C], shape [k]."""
    vertices_mm: np.ndarray
    """Mid-surface at each of them [mm], shape [k, n, 3]."""
    top_mm: np.ndarray
    """Top face of the hot shape [mm], shape [n, 3]."""
    triangles: np.ndarray
    """Vertex indices, shape [m, 3], int."""
    hottest: int
    """Place of the hot shape among the states."""


def thin_out(shape: HotShape) -> ThinnedHeating:
    """Keep all of a usual film; of a fine mesh vertices of its own that lie evenly, of a long ramp some states.

    The first state, those that were asked for and the hot shape are always kept.
    """
    states = _kept_states(shape)
    vertices, triangles = _kept_mesh(shape)
    return ThinnedHeating(
        temperature_c=shape.temperature_c[states],
        vertices_mm=shape.vertices_mm[states][:, vertices],
        top_mm=shape.top_mm[vertices],
        triangles=triangles,
        hottest=int(np.searchsorted(states, shape.hottest)),
    )


def _kept_states(shape: HotShape) -> np.ndarray:
    count = len(shape.temperature_c)
    if count <= MOST_STATES:
        return np.arange(count)
    even = np.linspace(0, count - 1, MOST_STATES).round().astype(int)
    return np.unique([*even, *(stop.index for stop in shape.stops), shape.hottest])


def _kept_mesh(shape: HotShape) -> tuple[np.ndarray, np.ndarray]:
    """Return which vertices are kept, shape [n], and the triangles between them, shape [m, 3]."""
    film = shape.film
    if len(film.triangles) <= MOST_TRIANGLES:
        return np.arange(len(film.flat_mm)), film.triangles
    edge_mm = sqrt(4 / sqrt(3) * float(film.area_mm2.sum()) / MOST_TRIANGLES)
    coarse = coarsen(film, edge_mm)
    return np.asarray(KDTree(film.flat_mm).query(coarse.flat_mm)[1]), coarse.triangles
