"""All layers alike around a point: cones and anticones, whose angles follow from the contraction alone."""

import logging
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks.validation.charts import draw_films
from benchmarks.validation.films import ALL, THICKNESS_MM, azimuthal, disc, heated_free, radial, scratched
from benchmarks.validation.section import Check, Section, picture, table
from planner.errors import SolverError
from twin.predict import HotShape

logger = logging.getLogger(__name__)

RADIUS_MM = 10.0
MESH_MM = 0.6
ANTICONE_MESH_MM = 0.8
ANTICONE_LAYERS_MM = (0.2, 0.1)
FLANK_MM = (4.0, 8.0)
"""Flat radii between the blunt tip and the free rim."""
CONES = (0.1, 0.2, 0.3, 0.4)
ANTICONES = (0.05, 0.1, 0.2)
ANGLE_LIMIT_DEG = 1.0
EXCESS_LIMIT = 0.01
BANDS = 6
SECTORS = 90


def half_angle_deg(shape: HotShape) -> float:
    """Angle between a cone's axis and its generators [deg], from its flank."""
    radius = np.hypot(*shape.film.flat_mm.T)
    rim = shape.hot_mm[radius > radius.max() - 1e-3]
    axis = np.linalg.svd(rim - rim.mean(axis=0))[2][2]
    offset = shape.hot_mm - rim.mean(axis=0)
    height = offset @ axis
    distance = np.linalg.norm(offset - height[:, None] * axis, axis=1)
    flank = (radius > FLANK_MM[0]) & (radius < FLANK_MM[1])
    slope = np.polyfit(height[flank], distance[flank], 1)[0]
    return float(np.rad2deg(np.arctan(abs(slope))))


def total_angle(shape: HotShape) -> float:
    """Angle around the tip, over 2 pi: how fast circles grow in length with their distance along the film.

    By Gauss and Bonnet it is one less the curvature of the tip over 2 pi: below 1 for a cone, above for an anticone.
    On each triangle of the flank the flat radial and azimuthal directions are stretched by s and c; circles of flat
    radius r have the length 2 pi r c and lie s apart, so the angle is the ratio of their averages.
    """
    film = shape.film
    flat, hot = film.flat_mm[film.triangles], shape.hot_mm[film.triangles]
    edges = np.stack((flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]), axis=-1)
    bent = np.stack((hot[:, 1] - hot[:, 0], hot[:, 2] - hot[:, 0]), axis=-1)
    gradient = bent @ np.linalg.inv(edges)
    centre = flat.mean(axis=1)
    radius = np.hypot(*centre.T)
    outwards = centre / radius[:, None]
    around = np.column_stack((-outwards[:, 1], outwards[:, 0]))
    stretch_out = np.linalg.norm(np.einsum("tij,tj->ti", gradient, outwards), axis=1)
    stretch_around = np.linalg.norm(np.einsum("tij,tj->ti", gradient, around), axis=1)
    bounds = np.linspace(*FLANK_MM, BANDS + 1)
    circles, apart = [], []
    for low, high in pairwise(bounds):
        band = (radius >= low) & (radius < high)
        weight = film.area_mm2[band] / film.area_mm2[band].sum()
        circles.append(0.5 * (low + high) * (weight @ stretch_around[band]))
        apart.append(weight @ stretch_out[band])
    return float(np.polyfit(0.5 * (bounds[:-1] + bounds[1:]), circles, 1)[0] / np.mean(apart))


def waves(shape: HotShape) -> int:
    """Return how many times the flank rises and falls around the tip: 2 for a saddle."""
    radius = np.hypot(*shape.film.flat_mm.T)
    flank = (radius > FLANK_MM[0]) & (radius < FLANK_MM[1])
    points = shape.hot_mm - shape.hot_mm[radius.argmin()]
    axis = np.linalg.svd(points[flank] - points[flank].mean(axis=0))[2][2]
    angle = np.arctan2(*shape.film.flat_mm[flank].T[::-1])
    height = points[flank] @ axis / radius[flank]
    strength = [abs(np.exp(1j * wave * angle) @ height) for wave in range(1, 7)]
    return 1 + int(np.argmax(strength))


def _default_mesh() -> Check:
    """Try the anticones at the default mesh."""
    reached = []
    for contraction in ANTICONES:
        try:
            heated_free(scratched(disc(RADIUS_MM), MESH_MM, contraction, layers=ALL, direction=radial))
            reached.append(True)
        except SolverError as error:
            logger.info("anticone: %s", error)
            reached.append(False)
    answers = (f"{e:.0%} {'yes' if found else 'no'}" for e, found in zip(ANTICONES, reached, strict=True))
    return Check(
        name=f"anticones, H = {THICKNESS_MM:g} mm, mesh {MESH_MM:g} mm, can be heated",
        expected="full temperature is reached at every e",
        found=", ".join(answers),
        error="",
        passed=all(reached),
    )


def run(docs: Path) -> Section:
    """Compare cones with sin(half angle) = lambda^(3/2), anticones with the angle 2 pi lambda^(-3/2)."""
    cones, anticones, drawn, checks = [], [], [], []
    for contraction in CONES:
        shape = heated_free(scratched(disc(RADIUS_MM), MESH_MM, contraction, layers=ALL, direction=azimuthal))
        expected = float(np.rad2deg(np.arcsin((1.0 - contraction) ** 1.5)))
        found = half_angle_deg(shape)
        angle = total_angle(shape)
        cones.append(
            (
                f"{contraction:.0%}",
                f"{expected:.2f}",
                f"{found:.2f}",
                f"{found - expected:+.2f}",
                f"{(1 - contraction) ** 1.5:.3f}",
                f"{angle:.3f}",
            )
        )
        checks.append(
            Check(
                name=f"cone, half angle at e = {contraction:.0%}",
                expected=f"{expected:.2f} deg within {ANGLE_LIMIT_DEG:g}",
                found=f"{found:.2f} deg",
                error=f"{found - expected:+.2f} deg",
                passed=abs(found - expected) <= ANGLE_LIMIT_DEG,
            )
        )
        if contraction in (0.1, 0.3):
            drawn.append((f"cone, e = {contraction:.0%}", shape.hot_mm, shape.film.triangles))
    for contraction in ANTICONES:
        expected = (1.0 - contraction) ** -1.5
        for layer_mm in ANTICONE_LAYERS_MM:
            film = scratched(
                disc(RADIUS_MM), ANTICONE_MESH_MM, contraction, layers=ALL, direction=radial, layer_mm=layer_mm
            )
            shape = heated_free(film)
            found, count = total_angle(shape), waves(shape)
            error = found / expected - 1.0
            anticones.append(
                (
                    f"{contraction:.0%}",
                    f"{4 * layer_mm:g}",
                    f"{expected:.3f}",
                    f"{found:.3f}",
                    f"{error:+.2%}",
                    str(count),
                )
            )
        checks.append(
            Check(
                name=f"anticone, angle around the tip at e = {contraction:.0%}, H = {4 * ANTICONE_LAYERS_MM[-1]:g} mm",
                expected=f"{expected:.3f} x 2 pi within {EXCESS_LIMIT:.0%}, a saddle",
                found=f"{found:.3f} x 2 pi, {'a saddle' if count == 2 else f'{count} waves'}",
                error=f"{error:+.2%}",
                passed=abs(error) <= EXCESS_LIMIT and count == 2,
            )
        )
    drawn.append((f"anticone, e = {contraction:.0%}", shape.hot_mm, film.triangles))
    checks.append(_default_mesh())
    draw_films(docs, "validation-cones.png", drawn)
    return Section(
        title="Cones and anticones",
        checks=tuple(checks),
        blocks=(
            f"Discs of {RADIUS_MM:g} mm radius, all four layers scratched in circles (cones) or along radii "
            f"(anticones), mesh {MESH_MM:g} mm, read between {FLANK_MM[0]:g} and {FLANK_MM[1]:g} mm from the middle. "
            "The angle around the tip is the growth of circles with distance, over 2 pi. Anticones are meshed by "
            f"{ANTICONE_MESH_MM:g} mm: which way their saddle lies is decided by nothing but the mesh, and on a "
            "finer one Newton's method can creep along the way round without end (last line of their checks).",
            table(("cone, e", "half angle deg", "found", "error", "angle around / 2 pi", "found"), cones),
            table(("anticone, e", "H mm", "angle around / 2 pi", "found", "error", "waves"), anticones),
            picture("validation-cones.png", "two cones and an anticone"),
        ),
    )
