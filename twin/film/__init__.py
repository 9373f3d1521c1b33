"""The flat film: mesh, layers, and how passes become directors and contractions."""

from twin.film.build import FilmOptions, build_film, film_from_alignment, film_of_field
from twin.film.coarsen import carry, coarsen
from twin.film.film import Film
from twin.film.raster import AlignmentRaster, paint_passes

__all__ = [
    "AlignmentRaster",
    "Film",
    "FilmOptions",
    "build_film",
    "carry",
    "coarsen",
    "film_from_alignment",
    "film_of_field",
    "paint_passes",
]
