"""The same film on a coarser mesh, and shapes carried between meshes."""

import numpy as np
from scipy.interpolate import CloughTocher2DInterpolator
from scipy.spatial import KDTree

from planner.target import mesh_outline
from twin.film.film import Film

NEIGHBOURS = 14
"""Vertices that a quadratic is fitted to: about two rings on one side of a boundary."""


def coarsen(film: Film, edge_mm: float) -> Film:
    """Return the film meshed at `edge_mm`; each triangle averages alignment and thickness of the fine ones inside it.

    Alignment counts by the volume that has it.

    Args:
        film: the fine film: one piece without holes.
        edge_mm: edge length of the coarse triangles [mm].
    """
    flat, triangles = mesh_outline(outline_of(film), edge_mm)
    centre = film.flat_mm[film.triangles].mean(axis=1)
    coarse_centre = flat[triangles].mean(axis=1)
    # fine triangles go to the coarse triangle with the nearest centre: on a nearly regular mesh those inside it
    owner = np.asarray(KDTree(coarse_centre).query(centre)[1])
    empty = np.bincount(owner, minlength=len(triangles)) == 0
    nearest = KDTree(centre).query(coarse_centre[empty])[1]
    q = film.alignment
    thickness = film.layer_thickness_mm
    varies = thickness.ndim == 2
    volume = film.area_mm2 * (thickness if varies else np.ones((len(thickness), 1)))
    mean = np.stack([_means(owner, weight, values, len(triangles)) for weight, values in zip(volume, q, strict=True)])
    if varies:
        thickness = _means(owner, film.area_mm2, thickness.T, len(triangles)).T
        thickness[:, empty] = film.layer_thickness_mm[:, nearest]
    mean[:, empty] = q[:, nearest]
    return Film(
        flat_mm=flat,
        triangles=triangles,
        layer_thickness_mm=thickness,
        director_rad=0.5 * np.arctan2(mean[..., 1], mean[..., 0]),
        contraction=np.hypot(mean[..., 0], mean[..., 1]),
        modulus_ratio=film.modulus_ratio,
    )


def carry(source_flat_mm: np.ndarray, values: np.ndarray, flat_mm: np.ndarray) -> np.ndarray:
    """Carry vertex values from one mesh of a film to another, smoothly (C1), shape [n, k] -> [m, k].

    Vertices just beyond the source's hull follow the quadratic fit to the nearest source vertices.

    Args:
        source_flat_mm: flat vertices that the values belong to [mm], shape [n, 2].
        values: values at them, as deformed positions [mm], shape [n, k].
        flat_mm: flat vertices to carry to [mm], shape [m, 2].
    """
    carried = CloughTocher2DInterpolator(source_flat_mm, values)(flat_mm)
    outside = np.flatnonzero(np.isnan(carried).any(axis=1))
    if len(outside):
        nearest = np.asarray(KDTree(source_flat_mm).query(flat_mm[outside], k=NEIGHBOURS)[1])
        for vertex, around in zip(outside, nearest, strict=True):
            x, y = (source_flat_mm[around] - flat_mm[vertex]).T
            terms = np.column_stack((np.ones_like(x), x, y, x * x, x * y, y * y))
            carried[vertex] = np.linalg.lstsq(terms, values[around], rcond=None)[0][0]
    return carried


def _means(owner: np.ndarray, weight: np.ndarray, values: np.ndarray, count: int) -> np.ndarray:
    """Return the weighted means of values [m, k] that have the same owner, zero where nothing weighs, [count, k]."""
    sums = np.column_stack([np.bincount(owner, weight * column, count) for column in values.T])
    return sums / np.maximum(np.bincount(owner, weight, count), 1e-300)[:, None]


def boundary_edges(triangles: np.ndarray) -> np.ndarray:
    """Return the edges that only one triangle has, in its direction: vertex indices, shape [m, 3] -> [k, 2]."""
    ends = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    count = int(triangles.max()) + 1
    inner = np.isin(ends[:, 0] * count + ends[:, 1], ends[:, 1] * count + ends[:, 0])
    return ends[~inner]


def outline_of(film: Film) -> np.ndarray:
    """Return the boundary loop of a film without holes [mm], counter-clockwise, shape [k, 2]."""
    following = {int(a): int(b) for a, b in boundary_edges(film.triangles)}
    loop = [next(iter(following))]
    while (vertex := following[loop[-1]]) != loop[0]:
        loop.append(vertex)
    return film.flat_mm[loop]
