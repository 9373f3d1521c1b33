"""How much a flattening stretches the surface."""

from dataclasses import dataclass

import igl
import numpy as np

from planner.flattening.flattening import Flattening
from planner.flattening.orientation import signed_double_areas


@dataclass(frozen=True, kw_only=True)
class Distortion:
    """Length and area on the film against the surface; all values are shares, 0 = kept exactly."""

    length_median: float
    """Median of `|film / surface - 1|` over the edges."""
    length_95: float
    """95th percentile of the same."""
    length_max: float
    """Largest of the same."""
    area_median: float
    """Median of `|film / surface - 1|` over the triangles' areas."""
    area_95: float
    """95th percentile of the same."""
    area_max: float
    """Largest of the same."""
    total_area: float
    """Area of the whole film / area of the whole surface - 1, signed."""


def distortion(flattening: Flattening) -> Distortion:
    """Measure the distortion of each edge and triangle of the flattening."""
    vertices, film, triangles = flattening.vertices_mm, flattening.film_mm, flattening.triangles
    edges = np.asarray(igl.edges(np.ascontiguousarray(triangles, dtype=np.int64)))
    surface_length = np.linalg.norm(vertices[edges[:, 1]] - vertices[edges[:, 0]], axis=1)
    film_length = np.linalg.norm(film[edges[:, 1]] - film[edges[:, 0]], axis=1)
    sides = vertices[triangles[:, 1:]] - vertices[triangles[:, :1]]
    surface_area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    film_area = signed_double_areas(film, triangles)
    length = np.percentile(abs(film_length / surface_length - 1), [50, 95, 100])
    area = np.percentile(abs(film_area / surface_area - 1), [50, 95, 100])
    return Distortion(
        length_median=float(length[0]),
        length_95=float(length[1]),
        length_max=float(length[2]),
        area_median=float(area[0]),
        area_95=float(area[1]),
        area_max=float(area[2]),
        total_area=float(film_area.sum() / surface_area.sum() - 1),
    )
