"""A smooth director pattern at constant contraction: the Gaussian curvature that it imposes."""

from pathlib import Path

import numpy as np

from benchmarks.validation.charts import draw_films
from benchmarks.validation.films import ALL, disc, heated_free, scratched
from benchmarks.validation.section import Check, Section, picture, table
from twin.predict import HotShape

CONTRACTION = 0.1
GRADIENT_RAD_MM = 0.12
"""theta = offset + GRADIENT x."""
RADIUS_MM = 9.0
MIDDLE_MM = 4.0
"""Radius of the flat disc whose total curvature is compared."""
MESH_MM = 0.5
LAYERS_MM = (0.2, 0.1, 0.05)
OFFSETS = (("dome", 0.0), ("saddle", 0.5 * np.pi))
LIMIT = 0.05


def imposed_per_mm2(x_mm: np.ndarray, offset: float) -> np.ndarray:
    """Return K [1/mm^2] of theta = offset + c x at nu = 1/2: (lambda^-2 - lambda) c^2 cos 2 theta.

    The general formula, K = (lambda - lambda^-2)/2 ((th_yy - th_xx - 4 th_x th_y) sin 2 th
    + 2 (th_xy + th_y^2 - th_x^2) cos 2 th), with th_x = c and all else zero.
    """
    stretch = 1.0 - CONTRACTION
    return (stretch**-2 - stretch) * GRADIENT_RAD_MM**2 * np.cos(2.0 * (offset + GRADIENT_RAD_MM * x_mm))


def total_curvature(shape: HotShape, offset: float) -> tuple[float, float]:
    """Return the curvature of the middle imposed by the directors and found as angle defects [rad]."""
    film = shape.film
    inside = np.hypot(*film.flat_mm.T) <= MIDDLE_MM
    # the area of a stress-free film grows by lambda lambda^(-1/2)
    area = film.vertex_area_mm2 * np.sqrt(1.0 - CONTRACTION)
    expected = float((imposed_per_mm2(film.flat_mm[:, 0], offset) * area)[inside].sum())
    corners = shape.hot_mm[film.triangles]
    defect = np.full(len(film.flat_mm), 2.0 * np.pi)
    for corner in range(3):
        one = corners[:, (corner + 1) % 3] - corners[:, corner]
        two = corners[:, (corner + 2) % 3] - corners[:, corner]
        cosine = (one * two).sum(axis=1) / (np.linalg.norm(one, axis=1) * np.linalg.norm(two, axis=1))
        np.subtract.at(defect, film.triangles[:, corner], np.arccos(cosine))
    return expected, float(defect[inside].sum())


def run(docs: Path) -> Section:
    """Compare the total curvature of the middle of a dome and a saddle, from thick to thin films."""
    rows, checks, drawn = [], [], []
    for name, offset in OFFSETS:
        errors = []
        for layer_mm in LAYERS_MM:
            film = scratched(
                disc(RADIUS_MM),
                MESH_MM,
                CONTRACTION,
                layers=ALL,
                layer_mm=layer_mm,
                direction=lambda centre, start=offset: start + GRADIENT_RAD_MM * centre[:, 0],
            )
            shape = heated_free(film)
            expected, found = total_curvature(shape, offset)
            errors.append(found / expected - 1.0)
            rows.append((name, f"{4 * layer_mm:g}", f"{expected:+.4f}", f"{found:+.4f}", f"{errors[-1]:+.1%}"))
        drawn.append((f"{name}, H = {4 * LAYERS_MM[-1]:g} mm", shape.hot_mm, film.triangles))
        checks.append(
            Check(
                name=f"curvature of a director pattern, {name}, H = {4 * LAYERS_MM[-1]:g} mm",
                expected=f"{expected:+.4f} rad within {LIMIT:.0%}",
                found=f"{found:+.4f} rad",
                error=f"{errors[-1]:+.1%}",
                passed=abs(errors[-1]) <= LIMIT and abs(errors[-1]) < abs(errors[0]),
            )
        )
    draw_films(docs, "validation-directors.png", drawn)
    return Section(
        title="Curvature of a director pattern",
        checks=tuple(checks),
        blocks=(
            f"All four layers contract by {CONTRACTION:.0%} along theta = theta0 + {GRADIENT_RAD_MM:g} x [rad, mm] "
            f"on a disc of {RADIUS_MM:g} mm radius; mesh {MESH_MM:g} mm. Such a film has the curvature K = c^2 "
            "(lambda^-2 - lambda) cos 2 theta if it is thin; a thick one resists it. Compared is the total "
            f"curvature of the middle disc of {MIDDLE_MM:g} mm radius, the sum of its angle defects (Gauss and "
            "Bonnet).",
            table(("pattern", "H mm", "expected rad", "found", "error"), rows),
            picture("validation-directors.png", "the two thin films"),
        ),
    )
