"""Films on the hot plate: a flat one rests, a cap of radius 20 mm stands."""

from pathlib import Path

import numpy as np

from benchmarks.validation.charts import draw_films
from benchmarks.validation.films import THICKNESS_MM, rectangle, scratched
from benchmarks.validation.section import Check, Section, picture, relative, table
from planner.plan import plan
from scenes.case import load_case
from twin.bending import principal_curvatures_per_mm
from twin.film import FilmOptions, build_film
from twin.material import Material
from twin.predict import PLATE_PER_MM, PLATE_REACH_MM, PredictOptions, heat_film

MESH_MM = 0.8
MODULI_MPA = (0.2, 0.5, 2.0)
PENETRATION_MM = 1e-3


def run(docs: Path) -> Section:
    """Rest a polydomain film, and let the cap stand under its weight at three moduli and without weight."""
    material = Material()
    flat = heat_film(scratched(rectangle(30.0, 20.0), 1.0, 0.0), PredictOptions(device="cpu"))
    height = flat.hot_mm[:, 2]
    weight = material.weight_n_mm3 * THICKNESS_MM / material.shear_modulus_mpa
    # the plate pushes by stiffness d^2 / (2 reach) at a depth d below its reach
    expected = PLATE_REACH_MM - float(np.sqrt(2.0 * PLATE_REACH_MM * weight / PLATE_PER_MM))

    case = load_case("sphere_cap")
    film = build_film(plan(case.make_target(), seed=case.plan.seed).program, FilmOptions(mesh_mm=MESH_MM))
    rows, drawn, depths, domes, lowest = [], [], [], [], np.inf
    for modulus in (*MODULI_MPA, None):
        options = PredictOptions(
            support="plate" if modulus else "free", material=Material(modulus_mpa=modulus or 0.5), device="cpu"
        )
        shape = heat_film(film, options)
        curvature = principal_curvatures_per_mm(film, shape.hot_mm)
        if modulus:
            depths.append(float(np.ptp(shape.hot_mm[:, 2])))
            domes.append(bool(curvature[0] > 0.0))
            lowest = min(lowest, float(shape.hot_mm[:, 2].min()))
        label = f"E = {modulus:g} MPa" if modulus else "weightless"
        radii = ", ".join(f"{1.0 / value:.1f}" for value in curvature[::-1])
        rows.append((label, f"{depths[-1]:.2f}" if modulus else "", radii, "yes" if shape.stable else "no"))
        if modulus != MODULI_MPA[1]:
            drawn.append((label, shape.hot_mm, film.triangles))
    draw_films(docs, "validation-cap.png", drawn)
    stands = all(domes) and bool(np.all(np.diff(depths) > 0.0)) and depths[0] > 1.0
    return Section(
        title="On the plate",
        checks=(
            relative(
                "flat polydomain film rests at", 1e3 * expected, 1e3 * float(height.mean()), limit=1e-3, unit="um"
            ),
            Check(
                name="flat polydomain film stays flat",
                expected="0 within 1e-9 mm",
                found="below 1e-9 mm" if np.ptp(height) < 1e-9 else f"{np.ptp(height):.1e} mm",
                error="",
                passed=bool(np.ptp(height) < 1e-9),
            ),
            Check(
                name="cap of radius 20 mm, through passes, stands at E = 0.2, 0.5, 2 MPa",
                expected="a dome, the higher the stiffer",
                found=", ".join(f"{depth:.2f}" for depth in depths) + " mm high",
                error="",
                passed=stands,
            ),
            Check(
                name="nothing sinks into the plate",
                expected=f"above -{PENETRATION_MM:g} mm",
                found=f"lowest point {lowest:+.4f} mm",
                error="",
                passed=lowest > -PENETRATION_MM,
            ),
        ),
        blocks=(
            "The cap is the built-in case `sphere_cap` (radius 20 mm, 14 mm to its edge, 5.7 mm deep), planned by "
            f"the perpendicular method and heated through its passes, mesh {MESH_MM:g} mm. Radii are those of the "
            "principal curvatures of the film as a whole.",
            table(("cap", "height mm", "radii mm", "stable"), rows),
            picture("validation-cap.png", "the cap at two moduli and without weight"),
        ),
    )
