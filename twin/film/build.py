"""Turn a Program into a film: mesh the cut outline, paint the passes, average them over the triangles."""

import os
from collections.abc import Sequence

import numpy as np
from scipy.spatial import KDTree

from planner.alignment import AlignmentField
from planner.calibration import Calibration
from planner.errors import InputError
from planner.program import Program, load_machine
from planner.target import mesh_outline, signed_area
from twin.fading import pass_strengths, remaining_alignment
from twin.film.film import Film
from twin.film.options import FilmOptions
from twin.film.raster import paint_passes
from twin.film.skin import with_skin

BYTES_PER_TRIANGLE = 12_000
"""Peak memory of kernels, sparse pattern and factorisation, measured at 20 000 triangles and rounded up."""
SUBDIVISION = 4
"""A triangle averages the raster over the centres of its SUBDIVISION^2 similar sub-triangles."""
FIELD_REACH_MM = 0.3
MESH_MM_ALLOWED = (0.05, 5.0)


def build_film(program: Program, options: FilmOptions | None = None) -> Film:
    """Return the film that a Program makes.

    Raises:
        InputError: if the mesh size is out of range, coarser than the film allows or too fine for the memory, or
            another option is out of range or does not fit the Program's layers.
    """
    options = options or FilmOptions()
    options.check(len(program.layers))
    outline = np.asarray(program.cut.line_mm)
    _check_mesh_size(outline, options.mesh_mm)
    flat, triangles = mesh_outline(outline, options.mesh_mm)
    points = inner_points(flat[triangles])
    fading = _strengths(program, options)
    q = _painted(program, options, points, fading)
    thickness = options.layer_thickness_mm or tuple(layer.thickness_mm for layer in program.layers)
    film = film_from_alignment(
        flat,
        triangles,
        q,
        layer_thickness_mm=np.array(thickness),
        modulus_ratio=None if options.modulus_ratio is None else np.array(options.modulus_ratio, dtype=float),
    )
    if options.profile == "uniform":
        return film
    # how deep the post aligned does not change while the alignment fades
    scratched = None if fading is None else np.hypot(*np.moveaxis(_painted(program, options, points, None), -1, 0))
    return with_skin(film, program.calibration, scratched=scratched)


def _strengths(program: Program, options: FilmOptions) -> Sequence[np.ndarray] | None:
    """Return the factor on the contraction of each pass, shape [passes] for each layer; None where all are 1."""
    fading, own = None, options.pass_strength
    if options.fading_tau_h and options.pass_to_cure_s is not None:
        fading = tuple(remaining_alignment(waits, tau_h=options.fading_tau_h) for waits in options.pass_to_cure_s)
    elif options.fading_tau_h:
        fading = pass_strengths(program, options.machine or load_machine(), tau_h=options.fading_tau_h)
    if own is None or fading is None:
        return fading if own is None else tuple(map(np.asarray, own))
    return tuple(left * np.asarray(share) for left, share in zip(fading, own, strict=True))


def film_from_alignment(
    flat_mm: np.ndarray,
    triangles: np.ndarray,
    q: np.ndarray,
    *,
    layer_thickness_mm: np.ndarray,
    modulus_ratio: np.ndarray | None = None,
) -> Film:
    """Return a film from its alignment vectors q = e (cos 2 theta, sin 2 theta), shape [layers, m, 2]."""
    return Film(
        flat_mm=flat_mm,
        triangles=triangles,
        layer_thickness_mm=np.asarray(layer_thickness_mm, dtype=float),
        director_rad=0.5 * np.arctan2(q[..., 1], q[..., 0]),
        contraction=np.hypot(q[..., 0], q[..., 1]),
        modulus_ratio=np.ones(len(q)) if modulus_ratio is None else modulus_ratio,
    )


def _painted(
    program: Program, options: FilmOptions, points: np.ndarray, fading: Sequence[np.ndarray] | None
) -> np.ndarray:
    """Return the alignment vectors of each triangle, means over its points [m, points, 2], shape [layers, m, 2]."""
    outline = np.asarray(program.cut.line_mm)
    calibration = Calibration(program.calibration)
    return np.stack(
        [
            paint_passes(
                layer.passes,
                calibration,
                (outline.min(axis=0) - 1.0, outline.max(axis=0) + 1.0),
                line_width_mm=options.line_width_mm or program.film.line_width_mm,
                edge_blur_mm=options.edge_blur_mm,
                end_length_mm=options.end_length_mm,
                strength=strength,
            )
            .sample(points)
            .mean(axis=1)
            for layer, strength in zip(program.layers, fading or [None] * len(program.layers), strict=True)
        ]
    )


def inner_points(corners: np.ndarray) -> np.ndarray:
    """Return the centres of the SUBDIVISION^2 similar sub-triangles, shape [m, 3, 2] -> [m, points, 2]."""
    n = SUBDIVISION
    upright = [(3 * i + 1, 3 * j + 1) for i in range(n) for j in range(n - i)]
    inverted = [(3 * i + 2, 3 * j + 2) for i in range(n - 1) for j in range(n - 1 - i)]
    second, third = np.array(upright + inverted).T / (3.0 * n)
    weights = np.stack((1.0 - second - third, second, third), axis=1)
    return np.einsum("pk,mkd->mpd", weights, corners)


def _check_mesh_size(outline: np.ndarray, mesh_mm: float) -> None:
    low, high = MESH_MM_ALLOWED
    if not low <= mesh_mm <= high:
        raise InputError(f"mesh size: found {mesh_mm:g} mm, allowed are {low:g} to {high:g} mm; the default is 0.6 mm.")
    area = abs(signed_area(outline))
    triangles = area / (np.sqrt(3.0) / 4.0 * mesh_mm**2)
    if triangles < 8:
        raise InputError(
            f"mesh size: {mesh_mm:g} mm leaves about {triangles:.0f} triangles on a film of {area:.3g} mm2, "
            f"at least 8 are needed; use --mesh-mm {np.sqrt(area / 20.0):.2g} or less."
        )
    needed, free = triangles * BYTES_PER_TRIANGLE, _free_memory()
    if needed > free:
        affordable = mesh_mm * np.sqrt(needed / free)
        raise InputError(
            f"mesh size: {mesh_mm:g} mm on a film of {area:.3g} mm2 means {triangles:.2g} triangles and about "
            f"{needed / 1e9:.1f} GB of memory, free are {free / 1e9:.1f} GB; use --mesh-mm {affordable:.2f} or more."
        )


def _free_memory() -> float:
    """Return the memory that can still be taken [bytes]; infinite where the system does not say."""
    try:
        return float(os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (ValueError, OSError, AttributeError):
        return float("inf")


def film_of_field(
    field: AlignmentField, outline_mm: np.ndarray, mesh_mm: float, *, layer_thickness_mm: np.ndarray
) -> Film:
    """Return the film that would have learned an ideal field exactly, without passes: a bound, not a prediction.

    Points of the outline farther than FIELD_REACH_MM from every point of the field are polydomain.
    """
    _check_mesh_size(outline_mm, mesh_mm)
    flat, triangles = mesh_outline(outline_mm, mesh_mm)
    points = inner_points(flat[triangles])
    distance, nearest = KDTree(field.points_mm).query(points, distance_upper_bound=FIELD_REACH_MM)
    padded = np.concatenate((field.q, np.zeros((len(field.q), 1, 2))), axis=1)
    q = padded[:, np.where(np.isfinite(distance), nearest, field.q.shape[1])].mean(axis=2)
    return film_from_alignment(flat, triangles, q, layer_thickness_mm=layer_thickness_mm)
