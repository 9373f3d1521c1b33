"""Flattening as rigidly as possible, by libigl."""

import logging

import igl
import numpy as np

from planner.flattening.orientation import signed_double_areas

logger = logging.getLogger(__name__)

ARAP_ITERATIONS = 100
"""Local-global rounds; on scanned faces and terrain no vertex moves by more than 1e-5 mm after them."""
SLIM_ITERATIONS = 30


def arap_film_positions(vertices_mm: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, tuple[str, ...]]:
    """Lay a surface mesh flat with free edges, as rigidly as possible; return film positions [mm] and notes.

    Minimises the as-rigid-as-possible energy of the flat triangles (Liu et al. 2008, doi
    10.1111/j.1467-8659.2008.01290.x), starting from the surface seen from above, in which no triangle is folded.
    The energy puts no bound on compression, so very steep walls can fold; then the symmetric Dirichlet energy,
    which does (Rabinovich et al. 2017, doi 10.1145/2983621), is minimised from the same start instead.
    """
    seen_from_above = np.ascontiguousarray(vertices_mm[:, :2])
    faces = np.ascontiguousarray(triangles, dtype=np.int64)
    # Without a held vertex the linear system is singular: it knows the film only up to a translation.
    held = int(np.argmin(((seen_from_above - seen_from_above.mean(axis=0)) ** 2).sum(axis=1)))
    data = igl.ARAPData()
    data.max_iter = ARAP_ITERATIONS
    igl.arap_precomputation(np.ascontiguousarray(vertices_mm), faces, 2, np.array([held], dtype=np.int32), data)
    film = np.asarray(igl.arap_solve(seen_from_above[[held]], data, seen_from_above))
    folded = int(np.count_nonzero(signed_double_areas(film, faces) <= 0))
    if folded == 0:
        return film, ()
    note = (
        f"As-rigid-as-possible flattening folded {folded} of {len(faces)} triangles at steep walls; "
        "the film was flattened by the symmetric Dirichlet energy instead, which stretches more but cannot fold."
    )
    logger.info(note)
    return slim_film_positions(vertices_mm, faces), (note,)


def slim_film_positions(vertices_mm: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Lay a surface mesh flat with free edges by the symmetric Dirichlet energy; no triangle can fold."""
    seen_from_above = vertices_mm[:, :2]
    edges = vertices_mm[triangles[:, 1:]] - vertices_mm[triangles[:, :1]]
    surface_area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1).sum()
    scale = np.sqrt(surface_area / signed_double_areas(seen_from_above, triangles).sum())
    data = igl.slim_precompute(
        np.asfortranarray(vertices_mm),
        np.asfortranarray(triangles, dtype=np.int32),
        np.asfortranarray(seen_from_above * scale),
        igl.MappingEnergyType.SYMMETRIC_DIRICHLET,
        np.zeros(0, dtype=np.int32),
        np.asfortranarray(np.zeros((0, 2))),
        0.0,
    )
    return np.asarray(igl.slim_solve(data, SLIM_ITERATIONS))[:, :2].copy()
