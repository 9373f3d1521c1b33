"""Small strain: wide and narrow strips, a patch that may bend as it likes, and bilayers."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.validation.charts import new_figure, save
from benchmarks.validation.films import (
    BOTTOM,
    LAYERS,
    THICKNESS_MM,
    TOP,
    disc,
    heated_free,
    rectangle,
    scratched,
)
from benchmarks.validation.middle import middle_forms
from benchmarks.validation.section import Check, Section, picture, relative, table
from planner.target import mesh_outline
from twin.film import film_from_alignment

SMALL = 1e-4
"""Contraction at which a patch of a few mm is far from feeling that it bends both ways: its R is metres."""
PATCH_RADIUS_MM = 10.0
PATCH_MESHES_MM = (1.0, 0.5, 0.25)
"""The rim, as wide as a triangle, knows the bending of one side only: an error of first order in mesh over radius."""
STRIP = 0.02
WIDTHS = (1.0, 2.0, 4.0, 8.0, 12.0, 20.0, 30.0, 45.0, 70.0, 101.0)
LENGTH_MM = 32.0
LIMIT = 0.01
BILAYERS = (((1.0, 0.0), (0.0, 0.0)), ((1.0, 0.5), (0.7, 1.8)), ((0.4, 2.5), (1.0, 0.9)))
"""Contraction over SMALL and director [rad] of the lower and of the upper half."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Bent:
    """What a small film does, over e: (a - 1)/e and b H/e, shape [2, 2] each."""

    shrink: np.ndarray
    bend: np.ndarray


def patch(lower: tuple[float, float], upper: tuple[float, float], mesh_mm: float) -> Bent:
    """Heat a disc whose halves contract a little, each by (contraction over SMALL, director [rad])."""
    flat, triangles = mesh_outline(disc(PATCH_RADIUS_MM, 240), mesh_mm)
    q = np.empty((LAYERS, len(triangles), 2))
    for layers, (contraction, angle) in ((BOTTOM, lower), (TOP, upper)):
        q[list(layers)] = SMALL * contraction * np.array((np.cos(2.0 * angle), np.sin(2.0 * angle)))
    thickness = np.full(LAYERS, THICKNESS_MM / LAYERS)
    shape = heated_free(film_from_alignment(flat, triangles, q, layer_thickness_mm=thickness))
    forms = middle_forms(flat, shape.hot_mm, (0.5 * PATCH_RADIUS_MM, 0.5 * PATCH_RADIUS_MM))
    return Bent(shrink=(forms.first - np.eye(2)) / SMALL, bend=forms.second * THICKNESS_MM / SMALL)


def free_patch(lower: tuple[float, float], upper: tuple[float, float]) -> Bent:
    """The same, freed of the rim's first-order error by two meshes."""
    coarse, fine = (patch(lower, upper, mesh) for mesh in PATCH_MESHES_MM[1:])
    return Bent(shrink=fine.shrink, bend=2.0 * fine.bend - coarse.bend)


def metric(contraction: float, angle: float) -> np.ndarray:
    """Spontaneous metric R diag(lambda^2, 1/lambda) R^t of a layer, shape [2, 2]."""
    stretch, director = 1.0 - contraction, np.array((np.cos(angle), np.sin(angle)))
    along = np.outer(director, director)
    return stretch**2 * along + (np.eye(2) - along) / stretch


def run(docs: Path) -> Section:
    """Compare a free patch, bilayers of two directors, and strips from narrow to wide."""
    wanted = Bent(shrink=np.diag((-1.0, 0.5)), bend=np.diag((1.5, -0.75)))
    meshed = [patch((1.0, 0.0), (0.0, 0.0), mesh) for mesh in PATCH_MESHES_MM]
    free = Bent(shrink=meshed[-1].shrink, bend=2.0 * meshed[-1].bend - meshed[-2].bend)
    flipped = free_patch((0.0, 0.0), (1.0, 0.0))
    gaps = [float(np.abs(bent.bend - wanted.bend).max()) for bent in meshed]
    rim = gaps[-1] / 1.5
    determinant = float(np.linalg.det(free.bend))
    bilayers, worst = _bilayers()
    narrow, wide = _strips(docs)
    return Section(
        title="Small strain",
        checks=(
            _tensor("free patch, b H/e = 1.5 (nn - mm/2)", wanted.bend, free.bend),
            _tensor("free patch, (a - 1)/e = -(nn - mm/2)", wanted.shrink, free.shrink),
            Check(
                name="free patch, det b",
                expected="negative, -9/8 (e/H)^2 within 1.0%",
                found=f"{determinant:.3f} (e/H)^2",
                error=f"{determinant / -1.125 - 1.0:+.2%}",
                passed=abs(determinant / -1.125 - 1.0) <= LIMIT,
            ),
            _tensor("free patch, top layers bend the other way", -wanted.bend, flipped.bend),
            Check(
                name="bilayer: a = (A1 + A2)/2, b = 3/(4H) (A1 - A2)",
                expected=f"{len(BILAYERS)} pairs within 1.0%",
                found=f"{len(BILAYERS)} pairs",
                error=f"worst {worst:.2%}",
                passed=worst <= LIMIT,
            ),
            relative(f"wide strip at e = {STRIP:.0%}, curvature H/e", 1.125, wide, limit=0.02),
            relative(f"narrow strip at e = {STRIP:.0%}, curvature H/e", 1.5, narrow, limit=0.02),
        ),
        blocks=(
            f"A disc of {PATCH_RADIUS_MM:g} mm radius whose bottom half contracts by e = {SMALL:g} along n bends to "
            "radii of metres: it does not feel that its two curvatures do not fit together in the plane, and takes "
            "its preferred forms. Curvature is positive where convex. At the default mesh a disc this small, with "
            "nothing else to hold its shape, is a few percent too flat: presumably the rim's doing, one triangle "
            f"wide, where an edge knows the bending of one side only. The error ({rim:.1%} at {PATCH_MESHES_MM[-1]:g} "
            f"mm) is of first order in mesh over radius (rates {np.log2(gaps[0] / gaps[1]):.1f} and "
            f"{np.log2(gaps[1] / gaps[2]):.1f} from mesh to mesh) and is taken out of the values below and above by "
            "linear extrapolation. Films bent to a cylinder or a dome do not show it: their shape is held by what "
            "stretching costs.",
            table(
                ("free patch", "nn", "nm", "mm"),
                [
                    ("b H/e, expected", *_entries(wanted.bend)),
                    *(
                        (f"b H/e at {mesh:g} mm", *_entries(bent.bend))
                        for mesh, bent in zip(PATCH_MESHES_MM, meshed, strict=True)
                    ),
                    ("b H/e, extrapolated", *_entries(free.bend)),
                    ("b H/e, top layers, extrapolated", *_entries(flipped.bend)),
                    ("(a - 1)/e, expected", *_entries(wanted.shrink)),
                    ("(a - 1)/e, found", *_entries(free.shrink)),
                ],
            ),
            "Two halves with metrics A1 (bottom) and A2 (top) are one shell with rest forms a = (A1 + A2)/2 and b = "
            "3/(4H) (A1 - A2) (van Rees, Vouga, Mahadevan 2017; the sign is that of a convex film with negative b). "
            "Entries over e, and over e/H:",
            table(
                ("lower e, angle", "upper e, angle", "b H/e expected", "found", "(a - 1)/e expected", "found"), bilayers
            ),
            f"Strips of {LENGTH_MM:g} mm (10 mm if narrower than 4 mm), bottom layers e = {STRIP:.0%}, from narrow "
            "to wide; the narrow end is meshed by a twentieth of its width, and its rims still cost it a percent or "
            "two:",
            picture("validation-strips-width.png", "curvature of strips from narrow to wide"),
        ),
    )


def _entries(form: np.ndarray) -> tuple[str, ...]:
    return tuple(f"{value + 0.0:.4f}".replace("-0.0000", "0.0000") for value in (form[0, 0], form[0, 1], form[1, 1]))


def _tensor(name: str, wanted: np.ndarray, found: np.ndarray) -> Check:
    error = float(np.abs(found - wanted).max() / np.abs(wanted).max())
    return Check(
        name=name,
        expected=f"({', '.join(_entries(wanted))}) within {LIMIT:.1%}",
        found=f"({', '.join(_entries(found))})",
        error=f"{error:.2%}",
        passed=error <= LIMIT,
    )


def _bilayers() -> tuple[list[tuple[str, ...]], float]:
    rows, worst = [], 0.0
    for lower, upper in BILAYERS:
        first, second = metric(SMALL * lower[0], lower[1]), metric(SMALL * upper[0], upper[1])
        found = free_patch(lower, upper)
        wanted_a = (0.5 * (first + second) - np.eye(2)) / SMALL
        # the convex film of this page has positive curvature where b of the reference is negative
        wanted_b = -0.75 * (first - second) / SMALL
        a, b = found.shrink, found.bend
        worst = max(
            worst,
            float(np.abs(a - wanted_a).max() / np.abs(wanted_a).max()),
            float(np.abs(b - wanted_b).max() / np.abs(wanted_b).max()),
        )
        cells = (", ".join(_entries(form)) for form in (wanted_b, b, wanted_a, a))
        rows.append((*(f"{e:g}, {np.rad2deg(angle):.0f} deg" for e, angle in (lower, upper)), *cells))
    return rows, worst


def _strips(docs: Path) -> tuple[float, float]:
    curvature = []
    for width in WIDTHS:
        length = LENGTH_MM if width > 4.0 else 10.0
        film = scratched(rectangle(length, width), min(0.8, width / 20.0), STRIP)
        forms = middle_forms(film.flat_mm, heated_free(film).hot_mm, (4.0, min(4.0, 0.5 * width)))
        curvature.append(THICKNESS_MM / (STRIP * forms.radius_mm))
    figure = new_figure(6.4, 4.2)
    axes = figure.add_subplot()
    axes.semilogx(WIDTHS, curvature, "o-")
    for value, label in ((1.5, "narrow: 1.5"), (1.125, "wide: 1.125")):
        axes.axhline(value, color="k", ls=":", lw=1.0)
        axes.annotate(label, (WIDTHS[0], value), xytext=(0, 4), textcoords="offset points")
    axes.set(
        xlabel="width of the strip [mm]",
        ylabel="curvature H / e [1]",
        title=f"Strips at e = {STRIP:.0%}, H = {THICKNESS_MM:g} mm",
    )
    axes.grid(which="both", alpha=0.3)
    save(figure, docs, "validation-strips-width.png")
    return curvature[0], curvature[-1]
