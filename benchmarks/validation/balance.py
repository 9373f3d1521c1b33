"""Balance of forces, moments and energy: nothing comes from nowhere."""

from pathlib import Path

import numpy as np

from benchmarks.validation.films import MESH_MM, THICKNESS_MM, azimuthal, disc, rectangle, scratched
from benchmarks.validation.section import Check, Section
from twin.equilibrium import Newton, heat, rigid_pins
from twin.film import Film
from twin.material import Material
from twin.predict import PLATE_PER_MM, PLATE_REACH_MM, PredictOptions, heat_film
from twin.shell import Loads, Shell

FORCE_LIMIT = 1e-6
HEAT_LIMIT = 1e-4
INTERVALS = 16
"""Of Simpson's rule over the activation."""
NUDGE = 1e-4
"""Half step in activation of the central difference of the energy at rest positions."""


def run(docs: Path) -> Section:
    """Check the forces on a dome that lies on the plate, and the energy put into a strip by heating it."""
    dome = scratched(disc(12.0), MESH_MM, 0.1, direction=azimuthal)
    carried, moment, pushed = _on_plate(dome)
    put_in, stored = heating_work(scratched(rectangle(8.0, 12.0), 1.0, 0.2))
    error = abs(put_in / stored - 1.0)
    return Section(
        title="Balance of forces and energy",
        checks=(
            _small("plate carries the weight", carried, FORCE_LIMIT),
            _small("moment of weight and contact, over weight times radius", moment, FORCE_LIMIT),
            _small("elastic forces have no resultant, over their sum of sizes", pushed, FORCE_LIMIT),
            Check(
                name="energy put in by heating = energy stored",
                expected=f"equal within {HEAT_LIMIT:g}",
                found=f"{put_in:.5f} and {stored:.5f} mm3 (over mu)",
                error=f"below {HEAT_LIMIT:g}" if error <= HEAT_LIMIT else f"{error:.1e}",
                passed=error <= HEAT_LIMIT,
            ),
        ),
        blocks=(
            "A disc of 12 mm radius, bottom layers scratched in circles at e = 10 %, lies hot on the plate under "
            "its own weight. Contact, weight and elastic forces are taken from three shells of the same film, one "
            "load each.",
            "A free strip is heated in equilibrium from flat to e = 20 %. The heat that changes the layers' rest "
            "state at given positions is the only source of elastic energy: the integral of dE/dg at fixed vertices "
            f"over the activation g (Simpson, {INTERVALS} intervals) must be the energy at the end.",
        ),
    )


def _small(name: str, value: float, limit: float) -> Check:
    return Check(
        name=name,
        expected=f"0 within {limit:g}",
        found=f"below {limit:g}" if value <= limit else f"{value:.1e}",
        error="",
        passed=value <= limit,
    )


def _on_plate(film: Film) -> tuple[float, float, float]:
    """Return contact over weight less one, net moment and elastic resultant, all dimensionless."""
    material = Material()
    shape = heat_film(film, PredictOptions(device="cpu"))
    weight = material.weight_n_mm3 * THICKNESS_MM / material.shear_modulus_mpa
    loads = (
        Loads(),
        Loads(weight=weight),
        Loads(plate_per_mm=PLATE_PER_MM, plate_reach_mm=PLATE_REACH_MM),
    )
    activation = float(material.activation(shape.temperature_c[-1]))
    forces = []
    for load in loads:
        shell = Shell(film, loads=load, device="cpu")
        shell.set_activation(activation)
        forces.append(shell.gradient(shape.hot_mm)[1])
    elastic, pull, contact = forces[0], forces[1] - forces[0], forces[2] - forces[0]
    total = pull[:, 2].sum()
    moment = np.cross(shape.hot_mm, pull + contact).sum(axis=0)
    radius = np.hypot(*film.flat_mm.T).max()
    resultant = np.linalg.norm(elastic.sum(axis=0)) / np.linalg.norm(elastic, axis=1).sum()
    return (
        float(abs(contact[:, 2].sum() / total + 1.0)),
        float(np.linalg.norm(moment) / (total * radius)),
        float(resultant),
    )


def heating_work(film: Film) -> tuple[float, float]:
    """Return the integral of dE/dg at fixed vertices along the heated equilibrium, and the energy at its end [mm^3]."""
    shell = Shell(film, device="cpu")
    newton = Newton(shell, rigid_pins(film.flat_mm, on_plate=False))
    flat = np.column_stack((film.flat_mm, np.zeros(len(film.flat_mm))))
    shell.set_activation(1.0)
    scale = shell.driving_force(flat)
    nodes = np.linspace(0.0, 1.0, INTERVALS + 1)
    rates, state, energy = [], flat, 0.0
    try:
        for activation in nodes:
            if activation == 0.0:
                # the flat film is at rest and costs nothing: its energy is quadratic in g
                rates.append(0.0)
                continue
            if activation == nodes[1]:
                state = heat(newton, activation, rng=np.random.default_rng(0))[-1].equilibrium.vertices_mm
            shell.set_activation(activation)
            found = newton.solve(state, force_scale=scale, tolerance=1e-9)
            state, energy = found.vertices_mm, found.energy
            above, below = (_energy(shell, state, activation + nudge) for nudge in (NUDGE, -NUDGE))
            rates.append((above - below) / (2.0 * NUDGE))
    finally:
        newton.close()
    weights = np.ones(INTERVALS + 1)
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
    return float(weights @ rates) / (3.0 * INTERVALS), energy


def _energy(shell: Shell, vertices_mm: np.ndarray, activation: float) -> float:
    shell.set_activation(activation)
    return shell.energy(vertices_mm)
