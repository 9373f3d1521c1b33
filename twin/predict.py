"""Predict the hot shape that a Program makes: film, heating from flat, top face."""

import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from planner.errors import InputError, SolverError
from planner.program import Program
from twin.equilibrium import HeatedState, Newton, RampOptions, heat, rigid_pins
from twin.film import Film, FilmOptions, build_film, carry, coarsen
from twin.material import Material
from twin.shell import Loads, Shell
from twin.temperature import FieldNewton, FieldShell, TemperatureField, TemperatureUniform, plate_temperature_c

logger = logging.getLogger(__name__)

PLATE_PER_MM = 10.0
PLATE_REACH_MM = 0.01
"""The hot plate: a film floats up to 10 micrometres above it, and a whole face on a few corners does not sink in."""
TEMPERATURE_C_ALLOWED = (25.0, 200.0)

COARSEST_TRIANGLES = 1200
"""A film with more than four times as many is heated on a coarser mesh first."""

Support = Literal["plate", "free"]


@dataclass(frozen=True, kw_only=True)
class PredictOptions:
    """Settings of a prediction; the defaults are the paper's experiment."""

    film: FilmOptions = field(default_factory=FilmOptions)
    material: Material = field(default_factory=Material)
    ramp: RampOptions = field(default_factory=RampOptions)
    temperature_c: float = 150.0
    """Temperature of the plate that the film is heated to [C]."""
    temperature_field: TemperatureField = field(default_factory=TemperatureUniform)
    """Temperature of each part of the film: as the plate, by the gap model, or from a file."""
    support: Support = "plate"
    """`plate`: lying on the hot plate under its own weight; `free`: weightless, touching nothing."""
    coarse_to_fine: bool = True
    """Whether a fine film follows the ramp on coarser meshes and is solved itself only at the last temperature."""
    device: str = "auto"
    seed: int = 0
    """Seed of the small disturbance that the flat film starts with."""


@dataclass(frozen=True, kw_only=True, eq=False)
class HotShape:
    """The film at each accepted temperature of the ramp, flat and cold first, and how well it is in balance."""

    film: Film
    temperature_c: np.ndarray
    """Accepted temperatures [C], shape [k], ascending."""
    vertices_mm: np.ndarray
    """Mid-surface at each of them [mm], z = 0 on the plate, shape [k, n, 3].

    Where the ramp was followed on a coarser mesh, all but the last are carried over from there."""
    top_mm: np.ndarray
    """Top face at the last temperature, what a scanner sees [mm], shape [n, 3]."""
    energy_mj: float
    """Elastic energy plus that of weight and contact at the last temperature [mJ]."""
    relative_residual: float
    """Norm of the residual force over the norm of all element and load forces of the still-flat film."""
    stable: bool
    """Whether the Hessian is positive definite there."""
    lowest_stiffness_n_mm3: float
    """Its lowest eigenvalue per area: how stiffly the film opposes its softest disturbance [N/mm^3]."""
    tapped_away_at_c: tuple[float, ...]
    """Temperatures at which the film was held down only by its weight and a small tap let it jump elsewhere."""
    newton_iterations: int
    device: str
    wall_s: float

    @property
    def hot_mm(self) -> np.ndarray:
        """Mid-surface at the last temperature [mm], shape [n, 3]."""
        return self.vertices_mm[-1]


def predict(
    program: Program, options: PredictOptions | None = None, *, progress: Callable[[str, float], None] | None = None
) -> HotShape:
    """Mesh the Program's film, paint its passes, and heat it from flat.

    Args:
        program: what is done to the film; its passes are what is simulated, not the fields they came from.
        options: settings.
        progress: called with the stage's name and the share done, 0 to 1.

    Raises:
        InputError: if an option is out of range or the mesh does not fit the memory.
        SolverError: if no equilibrium is found.
    """
    options = options or PredictOptions()
    film = build_film(program, options.film)
    return heat_film(film, options, progress=progress)


def heat_film(
    film: Film, options: PredictOptions | None = None, *, progress: Callable[[str, float], None] | None = None
) -> HotShape:
    """Heat a film from flat to the temperature of the options; arguments and errors as of `predict`."""
    options = options or PredictOptions()
    low, high = TEMPERATURE_C_ALLOWED
    if not low <= options.temperature_c <= high:
        raise InputError(
            f"temperature: found {options.temperature_c:g} C, allowed are {low:g} to {high:g} C; the paper uses 150 C."
        )
    if options.seed < 0:
        raise InputError(f"seed: found {options.seed}, allowed is a whole number from 0; choose another.")
    if options.support not in ("plate", "free"):
        raise InputError(f"support: found {options.support!r}, allowed are plate and free; choose one of them.")
    if options.support == "free" and options.temperature_field.follows_shape:
        raise InputError(
            f"temperature field: {options.temperature_field.kind} needs the plate, found support 'free'; choose the "
            "support plate or the uniform field."
        )
    started = time.perf_counter()
    report = progress or (lambda stage, share: None)
    states, shell, stiffness = _heat(film, options, lambda share: report("heating", share))
    last = states[-1].equilibrium
    temperature = ramp_temperatures_c(states, options)
    return HotShape(
        film=film,
        temperature_c=temperature,
        vertices_mm=np.stack([state.equilibrium.vertices_mm for state in states]),
        top_mm=top_face(film, last.vertices_mm, shell.top_mm),
        energy_mj=last.energy * options.material.shear_modulus_mpa,
        relative_residual=last.relative_residual,
        stable=last.stable,
        lowest_stiffness_n_mm3=stiffness * options.material.shear_modulus_mpa,
        tapped_away_at_c=tuple(
            float(value) for value, state in zip(temperature, states, strict=True) if state.tapped_away_mm
        ),
        newton_iterations=sum(state.equilibrium.iterations for state in states),
        device=str(shell.device),
        wall_s=time.perf_counter() - started,
    )


def film_loads(film: Film, options: PredictOptions) -> Loads:
    """Return weight and plate as the options ask for them, over the shear modulus."""
    if options.support == "free":
        return Loads()
    material = options.material
    weight = material.weight_n_mm3 * film.thickness_mm / material.shear_modulus_mpa
    return Loads(weight=weight, plate_per_mm=PLATE_PER_MM, plate_reach_mm=PLATE_REACH_MM)


def open_newton(film: Film, options: PredictOptions) -> Newton:
    """Return the solver of a film under the loads and in the temperature field of the options."""
    loads = film_loads(film, options)
    pins = rigid_pins(film.flat_mm, on_plate=bool(loads.weight))
    if isinstance(options.temperature_field, TemperatureUniform):
        return Newton(Shell(film, loads=loads, device=options.device), pins)
    shell = FieldShell(
        film,
        field=options.temperature_field,
        material=options.material,
        temperature_c=options.temperature_c,
        loads=loads,
        device=options.device,
    )
    return FieldNewton(shell, pins)


def ramp_end(options: PredictOptions) -> float:
    """Return the end of a ramp: the activation of a uniform field, else the whole way of the plate's heating, 1."""
    if isinstance(options.temperature_field, TemperatureUniform):
        return float(options.material.activation(options.temperature_c))
    return 1.0


def ramp_temperatures_c(states: Sequence[HeatedState], options: PredictOptions) -> np.ndarray:
    """Return the temperature of the plate at each state of a whole ramp [C], shape [k]."""
    share = np.array([state.activation for state in states])
    if isinstance(options.temperature_field, TemperatureUniform):
        temperature = options.material.temperature_c(share)
        temperature[-1] = options.temperature_c
        return temperature
    return plate_temperature_c(share, options.material, options.temperature_c)


def _heat(
    film: Film, options: PredictOptions, progress: Callable[[float], None]
) -> tuple[list[HeatedState], Shell, float]:
    """Heat a film, a fine one by way of a coarser mesh.

    Returns the states, the shell as it is at the last temperature, and the lowest stiffness there [mu/mm].
    """
    carried = None
    if options.coarse_to_fine and len(film.triangles) > 4 * COARSEST_TRIANGLES:
        edge = float(np.sqrt(4.0 / np.sqrt(3.0) * film.area_mm2.mean()))
        coarse = coarsen(film, 2.0 * edge)
        states, _, _ = _heat(coarse, options, lambda share: progress(0.7 * share))
        together = np.concatenate([state.equilibrium.vertices_mm for state in states], axis=1)
        shapes = np.split(carry(coarse.flat_mm, together, film.flat_mm), len(states), axis=1)
        carried = [
            replace(state, equilibrium=replace(state.equilibrium, vertices_mm=shape))
            for state, shape in zip(states, shapes, strict=True)
        ]
    newton = open_newton(film, options)
    shell = newton.shell
    try:
        if carried is not None:
            try:
                last = _finish(newton, carried[-1], options.ramp.final_tolerance)
                progress(1.0)
                return [*carried[:-1], last], shell, newton.lowest_stiffness(last.equilibrium.vertices_mm)
            except SolverError as error:
                logger.info("the coarse shape leads nowhere on the fine mesh (%s): ramp on the fine mesh", error)
        rng = np.random.default_rng(options.seed)
        states = heat(newton, ramp_end(options), rng=rng, options=options.ramp, progress=progress)
        return states, shell, newton.lowest_stiffness(states[-1].equilibrium.vertices_mm)
    finally:
        newton.close()


def _finish(newton: Newton, carried: HeatedState, tolerance: float) -> HeatedState:
    """Solve the last state of a ramp on the fine mesh."""
    shell = newton.shell
    shell.set_activation(carried.activation)
    flat = np.column_stack((shell.film.flat_mm, np.zeros(shell.vertex_count)))
    scale = shell.driving_force(flat)
    found = newton.solve(carried.equilibrium.vertices_mm, force_scale=scale, tolerance=tolerance)
    iterations = carried.equilibrium.iterations + found.iterations
    return replace(carried, equilibrium=replace(found, iterations=iterations))


def top_face(film: Film, vertices_mm: np.ndarray, height_mm: np.ndarray) -> np.ndarray:
    """Return the top face [mm], shape [n, 3]: the mid-surface moved along its normals.

    Args:
        film: the film.
        vertices_mm: mid-surface [mm], shape [n, 3].
        height_mm: height of the top face above the mid-surface for each triangle [mm], shape [m].
    """
    corners = vertices_mm[film.triangles]
    area_normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(area_normal, axis=1)
    normal = np.zeros_like(vertices_mm)
    height, weight = np.zeros(len(vertices_mm)), np.zeros(len(vertices_mm))
    for corner in range(3):
        np.add.at(normal, film.triangles[:, corner], area_normal)
        np.add.at(height, film.triangles[:, corner], area * height_mm)
        np.add.at(weight, film.triangles[:, corner], area)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return vertices_mm + (height / weight)[:, None] * normal
