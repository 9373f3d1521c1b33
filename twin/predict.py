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
from twin.hot_shape import HotShape, Snap, Stop
from twin.material import Material
from twin.shell import Loads, Shell
from twin.temperature import (
    FieldNewton,
    FieldShell,
    TemperatureField,
    TemperatureUniform,
    plate_share,
    plate_temperature_c,
)

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
    temperatures_c: tuple[float, ...] | None = None
    """Temperatures to pass through one after the other, up and down, instead [C]; each shape is kept. The hot shape
    is that at the highest."""
    temperature_field: TemperatureField = field(default_factory=TemperatureUniform)
    """Temperature of each part of the film: as the plate, by the gap model, or from a file."""
    support: Support = "plate"
    """`plate`: lying on the hot plate under its own weight; `free`: weightless, touching nothing."""
    coarse_to_fine: bool = True
    """Whether a fine film follows the ramp on coarser meshes and is solved itself only at the last temperature."""
    device: str = "auto"
    seed: int = 0
    """Seed of the small disturbance that the flat film starts with."""

    @property
    def stops_c(self) -> tuple[float, ...]:
        """Temperatures that the film is asked to pass through, in their order [C]."""
        return (self.temperature_c,) if self.temperatures_c is None else self.temperatures_c

    @property
    def hottest_c(self) -> float:
        """The highest of them [C]."""
        return max(self.stops_c)

    def check(self) -> None:
        """Refuse settings of the heating that are out of range or do not fit together.

        Raises:
            InputError: with every problem found.
        """
        problems = []
        low, high = TEMPERATURE_C_ALLOWED
        outside = [value for value in self.stops_c if not low <= value <= high]
        if outside:
            problems.append(
                f"temperature: found {outside[0]:g} C, allowed are {low:g} to {high:g} C; the paper uses 150 C."
            )
        if not self.stops_c:
            problems.append("temperatures: found none, allowed is one or more; the paper uses 150 C.")
        if self.seed < 0:
            problems.append(f"seed: found {self.seed}, allowed is a whole number from 0; choose another.")
        if self.support not in ("plate", "free"):
            problems.append(f"support: found {self.support!r}, allowed are plate and free; choose one of them.")
        if self.support == "free" and self.temperature_field.follows_shape:
            problems.append(
                f"temperature field: {self.temperature_field.kind} needs the plate, found support 'free'; choose the "
                "support plate or the uniform field."
            )
        if problems:
            raise InputError(problems)


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
    options.check()
    started = time.perf_counter()
    report = progress or (lambda stage, share: None)
    newton = open_newton(film, options)
    try:
        states = _states(newton, options, lambda share: report("heating", share))
        stops = [index for index, state in enumerate(states) if state.stop]
        hottest = stops[int(np.argmax(options.stops_c))]
        activation, hot = states[hottest].activation, states[hottest].equilibrium
        newton.prescribe(activation, hot.vertices_mm)
        top_mm = top_face(film, hot.vertices_mm, newton.shell.top_mm)
        stiffness = newton.lowest_stiffness(hot.vertices_mm)
    finally:
        newton.close()
    temperature = ramp_temperatures_c(states, options)
    numbered = list(enumerate(states))
    return HotShape(
        film=film,
        temperature_c=temperature,
        vertices_mm=np.stack([state.equilibrium.vertices_mm for state in states]),
        stops=tuple(
            Stop(
                temperature_c=float(temperature[index]),
                index=index,
                stable=states[index].equilibrium.stable,
                relative_residual=states[index].equilibrium.relative_residual,
            )
            for index in stops
        ),
        hottest=hottest,
        top_mm=top_mm,
        energy_mj=hot.energy * options.material.shear_modulus_mpa,
        relative_residual=hot.relative_residual,
        stable=hot.stable,
        lowest_stiffness_n_mm3=stiffness * options.material.shear_modulus_mpa,
        tapped_away_at_c=tuple(float(temperature[index]) for index, state in numbered if state.tapped_away_mm),
        snaps=tuple(
            Snap(
                temperature_c=float(temperature[index]),
                distance_mm=state.snapped_mm,
                cooling=bool(temperature[index] < temperature[index - 1]),
            )
            for index, state in numbered
            if state.snapped_mm
        ),
        newton_iterations=sum(state.equilibrium.iterations for state in states),
        device=str(newton.shell.device),
        wall_s=time.perf_counter() - started,
    )


def film_loads(film: Film, options: PredictOptions) -> Loads:
    """Return weight and plate as the options ask for them, over the shear modulus."""
    if options.support == "free":
        return Loads()
    material = options.material
    weight = material.weight_n_mm3 * film.vertex_thickness_mm / material.shear_modulus_mpa
    return Loads(weight=weight, plate_per_mm=PLATE_PER_MM, plate_reach_mm=PLATE_REACH_MM)


def open_newton(film: Film, options: PredictOptions) -> Newton:
    """Return the solver of a film under the loads and in the temperature field of the options."""
    loads = film_loads(film, options)
    pins = rigid_pins(film.flat_mm, on_plate=loads.heavy)
    if isinstance(options.temperature_field, TemperatureUniform):
        return Newton(Shell(film, loads=loads, device=options.device), pins)
    shell = FieldShell(
        film,
        field=options.temperature_field,
        material=options.material,
        temperature_c=options.hottest_c,
        loads=loads,
        device=options.device,
    )
    return FieldNewton(shell, pins)


def ramp_end(options: PredictOptions) -> float:
    """Return the end of a ramp: the activation of a uniform field, else the whole way of the plate's heating, 1."""
    return _ramp_place(options, options.hottest_c)


def _ramp_place(options: PredictOptions, temperature_c: float) -> float:
    """Return where on a ramp the plate has a temperature: an activation, or a share of the plate's heating."""
    if isinstance(options.temperature_field, TemperatureUniform):
        return float(options.material.activation(temperature_c))
    return float(plate_share(temperature_c, options.material, options.hottest_c))


def ramp_temperatures_c(states: Sequence[HeatedState], options: PredictOptions) -> np.ndarray:
    """Return the temperature of the plate at each state of a whole ramp [C], shape [k]."""
    share = np.array([state.activation for state in states])
    if isinstance(options.temperature_field, TemperatureUniform):
        temperature = options.material.temperature_c(share)
    else:
        temperature = plate_temperature_c(share, options.material, options.hottest_c)
    temperature[[state.stop for state in states]] = options.stops_c
    return temperature


def _states(newton: Newton, options: PredictOptions, progress: Callable[[float], None]) -> list[HeatedState]:
    """Heat a film from flat through the stops, a fine one by way of a coarser mesh."""
    film = newton.shell.film
    if options.coarse_to_fine and len(film.triangles) > 4 * COARSEST_TRIANGLES:
        carried = _carried(film, options, lambda share: progress(0.7 * share))
        try:
            states = [_finish(newton, state, options.ramp) if state.stop else state for state in carried]
        except SolverError as error:
            logger.info("the coarse shape leads nowhere on the fine mesh (%s): ramp on the fine mesh", error)
        else:
            progress(1.0)
            return states
    places = [_ramp_place(options, temperature) for temperature in options.stops_c]
    rng = np.random.default_rng(options.seed)
    return heat(newton, places, rng=rng, options=options.ramp, progress=progress)


def _carried(film: Film, options: PredictOptions, progress: Callable[[float], None]) -> list[HeatedState]:
    """Heat a film on a mesh of twice the edge length, and carry its shapes over."""
    edge = float(np.sqrt(4.0 / np.sqrt(3.0) * film.area_mm2.mean()))
    coarse = coarsen(film, 2.0 * edge)
    newton = open_newton(coarse, options)
    try:
        states = _states(newton, options, progress)
    finally:
        newton.close()
    together = np.concatenate([state.equilibrium.vertices_mm for state in states], axis=1)
    shapes = np.split(carry(coarse.flat_mm, together, film.flat_mm), len(states), axis=1)
    return [
        replace(state, equilibrium=replace(state.equilibrium, vertices_mm=shape))
        for state, shape in zip(states, shapes, strict=True)
    ]


def _finish(newton: Newton, carried: HeatedState, options: RampOptions) -> HeatedState:
    """Solve a stop of a ramp on the fine mesh."""
    shell = newton.shell
    shell.set_activation(carried.activation)
    flat = np.column_stack((shell.film.flat_mm, np.zeros(shell.vertex_count)))
    scale = shell.driving_force(flat)
    found = newton.solve(carried.equilibrium.vertices_mm, force_scale=scale, tolerance=options.final_tolerance)
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
