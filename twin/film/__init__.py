"""The flat film: mesh, layers, and how passes become directors and contractions."""

from twin.film.build import build_film, film_from_alignment, film_of_field
from twin.film.coarsen import boundary_edges, carry, coarsen, outline_of
from twin.film.film import Film
from twin.film.options import FilmOptions, Profile
from twin.film.raster import AlignmentRaster, paint_passes
from twin.film.skin import with_skin

__all__ = [
    "AlignmentRaster",
    "Film",
    "FilmOptions",
    "Profile",
    "boundary_edges",
    "build_film",
    "carry",
    "coarsen",
    "film_from_alignment",
    "film_of_field",
    "outline_of",
    "paint_passes",
    "with_skin",
]
