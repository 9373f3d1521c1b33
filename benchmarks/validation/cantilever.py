"""Films held along a line sag under their weight: small sags against the formula, large ones against the elastica."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.integrate import solve_bvp

from benchmarks.validation.charts import new_figure, save
from benchmarks.validation.films import MESH_MM, THICKNESS_MM, rectangle, scratched
from benchmarks.validation.section import Section, picture, relative, table
from twin.equilibrium import Newton
from twin.material import Material
from twin.shell import Loads, Shell

WIDTH_MM = 60.0
NU = 0.5
SMALL_WEIGHT = 0.02
"""Share of the weight at which the sag is small: its formula is linear."""
MESHES_MM = (1.2, 0.6, 0.3)
ON_LINE = 0.55
"""Vertices this close to the clamped line are held [edges]: one or two of each row of the lattice."""
LIMIT = 0.02
FLAPS = ((10.0, 0.3), (15.0, 0.3), (15.0, 1.0))
"""Length [mm] and modulus [MPa] of flaps under their full weight."""


@dataclass(frozen=True, kw_only=True)
class Flap:
    """A film reaching out from a clamp, as wide as WIDTH_MM."""

    length_mm: float
    modulus_mpa: float
    weight_share: float = 1.0

    @property
    def weight_mpa(self) -> float:
        """Weight per area [N/mm^2]."""
        return self.weight_share * Material().weight_n_mm3 * THICKNESS_MM

    @property
    def formula_mm(self) -> float:
        """Small sag of a wide strip: 1.5 rho g L^4 (1 - nu^2) / (E H^2) [mm]."""
        per_thickness = self.weight_mpa / THICKNESS_MM
        return 1.5 * per_thickness * self.length_mm**4 * (1.0 - NU**2) / (self.modulus_mpa * THICKNESS_MM**2)

    def elastica_mm(self) -> float:
        """Sag of an inextensible wide strip at any deflection: D theta'' = -w (L - s) cos theta [mm]."""
        stiffness = self.modulus_mpa * THICKNESS_MM**3 / (12.0 * (1.0 - NU**2))
        ratio = self.weight_mpa * self.length_mm**3 / stiffness
        s = np.linspace(0.0, 1.0, 101)
        solution = solve_bvp(
            lambda s, y: np.stack((y[1], -ratio * (1.0 - s) * np.cos(y[0]))),
            lambda start, end: np.array((start[0], end[1])),
            s,
            np.stack((0.1 * s, 0.1 * (1.0 - s))),
            tol=1e-8,
        )
        fine = np.linspace(0.0, 1.0, 2001)
        return self.length_mm * float(np.trapezoid(np.sin(solution.sol(fine)[0]), fine))


def sag_mm(flap: Flap, mesh_mm: float) -> tuple[float, np.ndarray]:
    """Return the twin's sag in the middle of the free edge [mm], and the profile (x, z) of the middle line.

    Two flaps reach out from their common clamped line, the y axis: it is level there on
    both sides alike, so that the held vertices are a clamp without a rim of its own.
    """
    film = scratched(rectangle(2.0 * flap.length_mm, WIDTH_MM), mesh_mm, 0.0)
    weight = flap.weight_mpa / (flap.modulus_mpa / 3.0)
    shell = Shell(film, loads=Loads(weight=weight), device="cpu")
    x, y = film.flat_mm.T
    line = np.flatnonzero(np.abs(x) <= ON_LINE * mesh_mm)
    newton = Newton(shell, np.sort(np.concatenate([3 * line + axis for axis in range(3)])))
    try:
        flat = np.column_stack((film.flat_mm, np.zeros(len(x))))
        found = newton.solve(flat, force_scale=shell.driving_force(flat), tolerance=1e-8).vertices_mm
    finally:
        newton.close()
    middle = np.abs(y) <= 0.1 * WIDTH_MM
    tip = middle & (x > x.max() - 1e-6)
    order = np.flatnonzero(middle)[np.argsort(found[middle, 0])]
    return float(-found[tip, 2].mean()), found[order][:, (0, 2)]


def run(docs: Path) -> Section:
    """Compare a small sag with the formula over three meshes, and flaps under their full weight with the elastica."""
    small = Flap(length_mm=10.0, modulus_mpa=0.3, weight_share=SMALL_WEIGHT)
    sags = [sag_mm(small, mesh)[0] for mesh in MESHES_MM]
    errors = np.array(sags) / small.formula_mm - 1.0
    rates = np.log2(errors[:-1] / errors[1:])
    rows, checks = [], []
    figure = new_figure(7.0, 4.0)
    axes = figure.add_subplot()
    for length, modulus in FLAPS:
        flap = Flap(length_mm=length, modulus_mpa=modulus)
        found, profile = sag_mm(flap, MESH_MM)
        exact = flap.elastica_mm()
        rows.append(
            (
                f"{length:g}",
                f"{modulus:g}",
                f"{flap.formula_mm:.2f}",
                f"{exact:.2f}",
                f"{found:.2f}",
                f"{found / exact - 1.0:+.1%}",
            )
        )
        name = f"flap of {length:g} mm, E = {modulus:g} MPa, full weight: sag by the elastica"
        checks.append(relative(name, exact, found, limit=LIMIT, unit="mm", digits=3))
        right = profile[:, 0] >= 0.0
        axes.plot(*profile[right].T, ".", ms=3, label=f"{length:g} mm, E = {modulus:g} MPa: {found:.2f} mm")
    axes.set(
        xlabel="distance from the clamp [mm]",
        ylabel="height [mm]",
        title="Flaps under their own weight",
        aspect="equal",
    )
    axes.legend(loc="lower left")
    axes.grid(alpha=0.3)
    save(figure, docs, "validation-flaps.png")
    full = Flap(length_mm=10.0, modulus_mpa=0.3)
    at_default = sags[MESHES_MM.index(MESH_MM)]
    return Section(
        title="Films that sag",
        checks=(
            relative(
                f"cantilever, 10 mm, E = 0.3 MPa, at {SMALL_WEIGHT:.0%} of the weight",
                small.formula_mm,
                at_default,
                limit=LIMIT,
                unit="mm",
            ),
            *checks,
        ),
        blocks=(
            f"Two flaps {WIDTH_MM:g} mm wide reach out from a common line whose vertices, up to half an edge away, "
            "are held; no plate. The formula w = 1.5 rho g L^4 (1 - nu^2)/(E H^2) is that of small sags: at 10 mm "
            f"and 0.3 MPa it gives {full.formula_mm:.2f} mm, of which the flap's own shortening takes "
            f"{1.0 - full.elastica_mm() / full.formula_mm:.1%}. It is therefore compared at {SMALL_WEIGHT:.0%} of "
            "the weight:",
            table(
                ("mesh mm", "formula mm", "found", "error"),
                [
                    (f"{mesh:g}", f"{small.formula_mm:.5f}", f"{sag:.5f}", f"{error:+.2%}")
                    for mesh, sag, error in zip(MESHES_MM, sags, errors, strict=True)
                ],
            ),
            f"Observed rates {rates[0]:.1f} and {rates[1]:.1f}. Under their full weight flaps are compared with the "
            "elastica (inextensible, any deflection, the same bending stiffness):",
            table(("L mm", "E MPa", "formula mm", "elastica", "found", "error"), rows),
            picture("validation-flaps.png", "profiles of three flaps"),
        ),
    )
