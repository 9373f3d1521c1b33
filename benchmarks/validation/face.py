"""The built-in face, through its passes, of a soft, a middling and a stiff elastomer side by side."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from benchmarks.validation.charts import new_figure, save
from benchmarks.validation.section import Check, Section, picture, table
from planner.plan import plan
from scenes.case import load_case
from twin.film import FilmOptions, build_film
from twin.material import Material
from twin.predict import PredictOptions, heat_film
from twin.score import score_surface

MESH_MM = 0.8
MODULI_MPA = (0.2, 0.5, 2.0)


def run(docs: Path) -> Section:
    """Predict and score the face at three moduli."""
    case = load_case("face")
    target = case.make_target()
    film = build_film(plan(target, seed=case.plan.seed).program, FilmOptions(mesh_mm=MESH_MM))
    rows, images, depths = [], [], []
    for modulus in MODULI_MPA:
        shape = heat_film(film, PredictOptions(material=Material(modulus_mpa=modulus), device="cpu"))
        scored = score_surface(shape.top_mm, film.triangles, target)
        score = scored.score
        depths.append(score.depth_mm)
        if not images:
            images.append((f"target {target.name}", scored.target_depth_mm))
        images.append((f"E = {modulus:g} MPa: SSIM {score.ssim_eq4:.2f}", scored.shape_depth_mm))
        rows.append(
            (
                f"{modulus:g}",
                f"{score.ssim_eq4:.3f}",
                f"{score.ssim_eq4_own_scale:.3f}",
                f"{score.rms_mm:.2f}",
                f"{score.depth_mm:.1f} of {score.target_depth_mm:.1f}",
                "yes" if shape.stable else "no",
            )
        )
    figure = new_figure(11.0, 4.4)
    _draw(figure, images)
    save(figure, docs, "validation-face.png")
    return Section(
        title="The face at three moduli",
        checks=(
            Check(
                name="face at E = 0.2, 0.5, 2 MPa",
                expected="no promise; all three are reached",
                found="SSIM "
                + ", ".join(row[1] for row in rows)
                + "; depth "
                + ", ".join(f"{d:.1f}" for d in depths)
                + " mm",
                error="",
                passed=None,
            ),
        ),
        blocks=(
            f"The built-in face, perpendicular plan, through its passes, mesh {MESH_MM:g} mm. The hot modulus of the "
            "paper's ink is not published; literature has 0.2 to 2 MPa. Weight decides how deep the face is, and "
            "with it the score.",
            table(("E MPa", "SSIM Eq. 4", "own scale", "RMS mm", "depth mm", "stable"), rows),
            picture("validation-face.png", "target and predicted depth images at three moduli"),
        ),
    )


def _draw(figure: Figure, images: list[tuple[str, np.ndarray]]) -> None:
    """Depth images, each in grey from its lowest to its highest point, so that shallow faces can be seen too."""
    for axes, (title, depth) in zip(figure.subplots(1, len(images)), images, strict=True):
        shown = axes.imshow(depth, cmap="gray", interpolation="nearest")
        axes.set_facecolor("black")
        axes.set_title(title, fontsize=10)
        axes.set(xticks=[], yticks=[])
        figure.colorbar(shown, ax=axes, location="bottom", label="height [mm]", shrink=0.9)
