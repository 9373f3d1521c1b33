"""Inverse design: a Program whose film becomes the target (paper, section 4: left there for future work).

Coarse to fine, each stage starting from the last one's film:

1. at the target: flat film and alignment with the least energy when bent into it, without solving for equilibrium;
2. coarse: through the equilibrium under weight and plate, in the basin that the ramp from flat finds;
3. middle: the same on a finer mesh;
4. lines through the fields, a load for each pass;
5. passes: the speeds along them, through the film that they really make;
6. check: the Program heated from flat, as `lce predict` does.
"""

import logging
import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np
import scipy.sparse as sp
from scipy.interpolate import CubicSpline

from planner.calibration import Calibration, load_calibration
from planner.plan import DIGITS, RIM_MM
from planner.program import (
    Actuate,
    CreatedBy,
    Cut,
    Inputs,
    Layer,
    LayerTime,
    Machine,
    Problem,
    Program,
    check,
    layer_times,
    load_machine,
)
from planner.program import Film as DepositedFilm
from planner.target import Target, mesh_outline
from planner.toolpaths.dense import Tiling
from twin.equilibrium import rigid_distance_mm
from twin.film import FilmOptions, carry, film_from_alignment, outline_of
from twin.hot_shape import HotShape
from twin.inverse.anchor import Anchor
from twin.inverse.at_target import design_at_target
from twin.inverse.basin import WEIGHTS_PER_MM3, descend, descend_in_basin
from twin.inverse.field_control import FieldControl
from twin.inverse.limits import describe_limits
from twin.inverse.mismatch import Mismatch
from twin.inverse.noise import noise_worlds
from twin.inverse.options import InverseOptions
from twin.inverse.painted import painted_layer
from twin.inverse.pass_control import PassControl
from twin.inverse.refine import Control, Design, Refinement
from twin.inverse.traced import (
    TracedLayer,
    contraction_range,
    pass_bounds,
    pass_contraction,
    trace_layer,
    with_contraction,
)
from twin.inverse.world import World
from twin.predict import heat_film, predict, ramp_end
from twin.score import Score, score_surface

logger = logging.getLogger(__name__)

SATURATION = 0.95
"""Largest contraction of the smooth fields, as a share of the calibration's: room for the passes to correct."""
FIELD_SMOOTHNESS = 1e-4
FIELD_DAMPING = 1e-3
PASS_SMOOTHNESS = 1e-4
PASS_DAMPING = 1e-4
PASS_WEIGHTS_PER_MM3 = (1e-5,)
"""Weight of the anchor for the passes: they start from fields that it has shaped, and the gaps between lines are no
fault that speeds could mend."""
OUTLINE_STEP_MM = 0.5
STEPS = {"coarse": 10, "middle": 7, "passes": 11}
BUDGET_SHARES = {"coarse": 0.25, "middle": 0.4, "passes": 0.7}
"""Share of the budget after which each stage ends: lines and check take the rest."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Moment:
    """A point on the way: what the design scores and what it looks like."""

    elapsed_s: float
    stage: str
    ssim: float
    """Eq. 4 of the designed shape, in the basin or not."""
    rms_mm: float
    top_mm: np.ndarray
    """Top face in the target's frame [mm], shape [n, 3]."""
    triangles: np.ndarray


@dataclass(frozen=True, kw_only=True, eq=False)
class Field:
    """A smooth design on its mesh: what one stage hands to the next, enough to go on from."""

    stage: str
    """Stage that made it, `coarse` or `middle`."""
    outline_mm: np.ndarray
    """Cut line of the flat film [mm], shape [k, 2]."""
    flat_mm: np.ndarray
    triangles: np.ndarray
    u: np.ndarray
    """Variables of a `FieldControl`, shape [layers, n, 2]."""
    vertices_mm: np.ndarray
    """Its equilibrium [mm], shape [n, 3]."""
    anchor_mm: np.ndarray
    """Where the vertices would be on the target [mm], shape [n, 3]."""
    weight_per_mm3: float
    """Weight of the anchor that the design was found with."""


@dataclass(frozen=True, kw_only=True, eq=False)
class InverseDesign:
    """A Program, what it is predicted to become, and how it was found."""

    program: Program
    shape: HotShape
    """The Program's film heated from flat."""
    score: Score
    ideal: Score
    """Score of the smooth fields without passes, heated from flat likewise."""
    designed_mm: float
    """Largest distance between the shape that was designed and the one that the ramp from flat finds [mm]."""
    tilings: tuple[Tiling, ...]
    """How each layer's passes tile its field."""
    layer_times: tuple[LayerTime, ...]
    problems: tuple[Problem, ...]
    history: tuple[Moment, ...]
    notes: tuple[str, ...]
    limits: tuple[str, ...]
    """What keeps the film from its target, sentence by sentence; empty where it gets there."""


class _Search:
    """Clock, history and progress of one design."""

    def __init__(
        self,
        options: InverseOptions,
        progress: Callable[[str, float], None] | None,
        watch: Callable[[Moment], None] | None,
    ) -> None:
        self._started, self._budget = time.perf_counter(), options.budget_s
        self._progress, self._watch = progress, watch
        self.history: list[Moment] = []

    def report(self, stage: str, share: float) -> None:
        if self._progress is not None:
            self._progress(stage, share)

    def watcher(self, stage: str, triangles: np.ndarray) -> Callable[[Design], bool]:
        """Return a function that records each design, and says whether there is time for another."""
        first = len(self.history)

        def go_on(design: Design) -> bool:
            measured = design.nominal.measured
            moment = Moment(
                elapsed_s=time.perf_counter() - self._started,
                stage=stage,
                ssim=measured.ssim,
                rms_mm=measured.rms_mm,
                top_mm=measured.transform.apply(design.nominal.top_mm),
                triangles=triangles,
            )
            logger.info("%s %.1f s: ssim %.4f, rms %.3f mm", stage, moment.elapsed_s, moment.ssim, moment.rms_mm)
            self.history.append(moment)
            self.report(stage, min(1.0, (len(self.history) - first) / (2 * STEPS[stage])))
            if self._watch is not None:
                self._watch(moment)
            return self._budget is None or moment.elapsed_s < BUDGET_SHARES[stage] * self._budget

        return go_on


def design_inverse(
    target: Target,
    *,
    calibration: Calibration | None = None,
    machine: Machine | None = None,
    options: InverseOptions | None = None,
    progress: Callable[[str, float], None] | None = None,
    watch: Callable[[Moment], None] | None = None,
    keep: Callable[[Field], None] | None = None,
    resume: Field | None = None,
) -> InverseDesign:
    """Find a Program whose film, heated from flat, becomes the target.

    Args:
        target: the surface.
        calibration: load and speed to contraction; None: the placeholder, which is not measured.
        machine: for times and the preflight; None: the paper's.
        options: settings.
        progress: called with the stage's name and the share done, 0 to 1.
        watch: called with each step's design.
        keep: called with the fields that the coarse and the middle stage end with, to save them.
        resume: such fields, of the same target and settings, to go on from.

    Raises:
        InputError: for wrong settings, or a target that cannot be meshed.
        SolverError: if not even the first design has an equilibrium.
    """
    options = options or InverseOptions()
    options.check()
    calibration, machine = calibration or load_calibration(), machine or load_machine()
    search = _Search(options, progress, watch)
    keep = keep or (lambda field: None)
    field = resume
    if field is None:
        search.report("first design", 0.0)
        field = _coarse(target, calibration, options, search)
        keep(field)
    if field.stage == "coarse":
        field = _middle(target, calibration, options, search, field)
        keep(field)
    search.report("lines", 0.0)
    traced = _traced(field, calibration, machine, options)
    layers, designed = _passes(target, calibration, options, search, field, traced)
    program = _program(target, calibration, machine, options, field, layers)
    search.report("check", 0.0)
    shape = predict(program, options.heated, progress=lambda stage, share: search.report("check", share))
    scored = score_surface(shape.top_mm, shape.film.triangles, target)
    ideal = _ideal(target, calibration, options, field)
    largest = contraction_range(calibration)[1]

    def left_over(changed: Target, thickness: float, contraction: float) -> float:
        layers = thickness * np.array(options.layer_thickness_mm)
        edge_mm = _edge_mm(_area(changed.outline_mm), options.coarse_triangles)
        first = design_at_target(
            changed,
            edge_mm=edge_mm,
            layer_thickness_mm=layers,
            largest=contraction * SATURATION * largest,
            stack=options.stack,
            activation=ramp_end(options.heated),
            seed=options.seed,
        )
        return first.energy_mm / float(layers.sum())

    meant = carry(designed[0], designed[1], shape.film.flat_mm)
    return InverseDesign(
        program=program,
        shape=shape,
        score=scored.score,
        ideal=ideal,
        designed_mm=rigid_distance_mm(shape.hot_mm, meant),
        tilings=tuple(layer.tiling for layer in traced),
        layer_times=layer_times(program, machine),
        problems=check(program, machine),
        history=tuple(search.history),
        notes=tuple(target.notes),
        limits=describe_limits(target, scored, shape.film, largest, left_over),
    )


def _coarse(target: Target, calibration: Calibration, options: InverseOptions, search: _Search) -> Field:
    first = design_at_target(
        target,
        edge_mm=_edge_mm(_area(target.outline_mm), options.coarse_triangles),
        layer_thickness_mm=np.array(options.layer_thickness_mm),
        largest=SATURATION * contraction_range(calibration)[1],
        stack=options.stack,
        activation=ramp_end(options.heated),
        seed=options.seed,
    )
    control = _field_control(first.triangles, len(first.flat_mm), calibration, options)
    worlds = _worlds(target, first.flat_mm, first.triangles, control, first.u, options)
    anchor = Anchor(
        first.vertices_mm,
        first.flat_mm,
        first.triangles,
        np.array(options.layer_thickness_mm),
        ramp_end(options.heated),
    )
    refinement = Refinement(worlds, control, anchor, weight_per_mm3=WEIGHTS_PER_MM3[0])
    nominal = worlds[0]
    try:
        go_on = search.watcher("coarse", first.triangles)
        design = refinement.design(first.u, [nominal.ramp(control.q(first.u))])
        go_on(design)
        design = descend_in_basin(
            refinement, nominal, design, weights_per_mm3=WEIGHTS_PER_MM3, steps=STEPS["coarse"], go_on=go_on
        )
    finally:
        _close(worlds)
    flat = film_from_alignment(
        first.flat_mm, first.triangles, design.q, layer_thickness_mm=np.array(options.layer_thickness_mm)
    )
    return Field(
        stage="coarse",
        outline_mm=_smooth_loop(outline_of(flat)),
        flat_mm=first.flat_mm,
        triangles=first.triangles,
        u=design.p,
        vertices_mm=design.nominal.vertices_mm,
        anchor_mm=first.vertices_mm,
        weight_per_mm3=refinement.weight_per_mm3,
    )


def _middle(target: Target, calibration: Calibration, options: InverseOptions, search: _Search, coarse: Field) -> Field:
    flat, triangles = mesh_outline(coarse.outline_mm, _edge_mm(_area(coarse.outline_mm), options.middle_triangles))
    carried = carry(coarse.flat_mm, np.hstack((coarse.vertices_mm, coarse.anchor_mm, *coarse.u)), flat)
    u = np.stack(np.split(carried[:, 6:], len(coarse.u), axis=1))
    control = _field_control(triangles, len(flat), calibration, options)
    worlds = _worlds(target, flat, triangles, control, u, options)
    try:
        anchor = Anchor(
            carried[:, 3:6], flat, triangles, np.array(options.layer_thickness_mm), ramp_end(options.heated)
        )
        refinement = Refinement(worlds, control, anchor, weight_per_mm3=coarse.weight_per_mm3)
        start = refinement.design(u, [carried[:, :3]])
        design = descend(refinement, start, steps=STEPS["middle"], go_on=search.watcher("middle", triangles))
    finally:
        _close(worlds)
    return Field(
        stage="middle",
        outline_mm=coarse.outline_mm,
        flat_mm=flat,
        triangles=triangles,
        u=design.p,
        vertices_mm=design.nominal.vertices_mm,
        anchor_mm=carried[:, 3:6],
        weight_per_mm3=coarse.weight_per_mm3,
    )


def _traced(
    field: Field, calibration: Calibration, machine: Machine, options: InverseOptions
) -> tuple[TracedLayer, ...]:
    control = _field_control(field.triangles, len(field.flat_mm), calibration, options)
    fields = control.vertex_q(field.u)

    def trace(index: int) -> TracedLayer:
        return trace_layer(
            field.flat_mm,
            field.triangles,
            fields[index],
            calibration,
            machine=machine,
            index=index,
            layers=len(fields),
            line_width_mm=options.line_width_mm,
            seed=options.seed,
        )

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return tuple(pool.map(trace, range(len(fields))))


def _passes(
    target: Target,
    calibration: Calibration,
    options: InverseOptions,
    search: _Search,
    field: Field,
    traced: tuple[TracedLayer, ...],
) -> tuple[tuple[tuple, ...], tuple[np.ndarray, np.ndarray]]:
    """Optimise the speeds; returns the passes of each layer, and the designed shape with its flat vertices."""
    outline = field.outline_mm
    flat, triangles = mesh_outline(outline, _edge_mm(_area(outline), options.pass_triangles))
    bounds = outline.min(axis=0) - 1.0, outline.max(axis=0) + 1.0
    corners = flat[triangles]

    def paint(layer: TracedLayer) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        return painted_layer(layer.passes, calibration, corners, bounds, FilmOptions(), options.line_width_mm)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        painted = list(pool.map(paint, traced))
    ranges = [pass_bounds(layer.passes, calibration) for layer in traced]
    control = PassControl(
        painted,
        [[len(stroke.speed_mm_s) for stroke in layer.passes] for layer in traced],
        np.concatenate([low for low, _ in ranges]),
        np.concatenate([high for _, high in ranges]),
        smoothness=PASS_SMOOTHNESS,
        damping=PASS_DAMPING,
    )
    p = control.start(np.concatenate([pass_contraction(layer.passes, calibration) for layer in traced]))
    worlds = _worlds(target, flat, triangles, control, p, options)
    try:
        carried = carry(field.flat_mm, np.hstack((field.vertices_mm, field.anchor_mm)), flat)
        anchor = Anchor(carried[:, 3:], flat, triangles, np.array(options.layer_thickness_mm), ramp_end(options.heated))
        refinement = Refinement(worlds, control, anchor, weight_per_mm3=field.weight_per_mm3)
        start = refinement.design(p, [carried[:, :3]])
        go_on = search.watcher("passes", triangles)
        design = descend_in_basin(
            refinement, worlds[0], start, weights_per_mm3=PASS_WEIGHTS_PER_MM3, steps=STEPS["passes"], go_on=go_on
        )
    finally:
        _close(worlds)
    counts = np.cumsum([len(low) for low, _ in ranges])[:-1]
    passes = tuple(
        with_contraction(layer.passes, own, calibration)
        for layer, own in zip(traced, np.split(control.contraction(design.p), counts), strict=True)
    )
    return passes, (flat, design.nominal.vertices_mm)


def _ideal(target: Target, calibration: Calibration, options: InverseOptions, field: Field) -> Score:
    control = _field_control(field.triangles, len(field.flat_mm), calibration, options)
    film = film_from_alignment(
        field.flat_mm, field.triangles, control.q(field.u), layer_thickness_mm=np.array(options.layer_thickness_mm)
    )
    shape = heat_film(film, options.heated)
    return score_surface(shape.top_mm, film.triangles, target).score


def _field_control(
    triangles: np.ndarray, count: int, calibration: Calibration, options: InverseOptions
) -> FieldControl:
    return FieldControl(
        triangles,
        count,
        layers=len(options.layer_thickness_mm),
        stack=options.stack,
        largest=SATURATION * contraction_range(calibration)[1],
        smoothness=FIELD_SMOOTHNESS,
        damping=FIELD_DAMPING,
    )


def _worlds(
    target: Target, flat: np.ndarray, triangles: np.ndarray, control: Control, p: np.ndarray, options: InverseOptions
) -> list[World]:
    film = film_from_alignment(flat, triangles, control.q(p), layer_thickness_mm=np.array(options.layer_thickness_mm))
    mismatch = Mismatch(target, triangles)
    distortions = [None, *(noise_worlds(film, options.noise, seed=options.seed) if options.robust else ())]
    return [World(film, mismatch, options.heated, distortion) for distortion in distortions]


def _close(worlds: list[World]) -> None:
    for world in worlds:
        world.newton.close()


def _program(
    target: Target,
    calibration: Calibration,
    machine: Machine,
    options: InverseOptions,
    field: Field,
    layers: tuple[tuple, ...],
) -> Program:
    every = np.concatenate([field.outline_mm, *(np.array(stroke.points_mm) for passes in layers for stroke in passes)])
    (left, low), (right, high) = every.min(axis=0) - RIM_MM, every.max(axis=0) + RIM_MM
    return Program(
        name=target.name,
        seed=options.seed,
        created_by=CreatedBy(name="lce-twin", version=version("lce-twin")),
        inputs=Inputs(
            method="inverse",
            target_name=target.name,
            target_sha256=target.digest,
            settings={"machine": machine.name, "stack": options.stack, "robust": options.robust},
        ),
        calibration=calibration.record,
        film=DepositedFilm(
            outline_mm=_tuples(np.array([(left, low), (right, low), (right, high), (left, high)])),
            layer_thickness_mm=options.layer_thickness_mm,
            line_width_mm=options.line_width_mm,
        ),
        layers=tuple(
            Layer.of(index, thickness, passes)
            for index, (thickness, passes) in enumerate(zip(options.layer_thickness_mm, layers, strict=True))
        ),
        finish=(Cut(line_mm=_tuples(field.outline_mm)), Actuate(temperature_c=options.heated.temperature_c)),
    )


def _tuples(points: np.ndarray) -> tuple[tuple[float, float], ...]:
    return tuple((x, y) for x, y in np.round(points, DIGITS).tolist())


def _smooth_loop(loop_mm: np.ndarray) -> np.ndarray:
    """Return a closed line through the points of another, smooth, its points OUTLINE_STEP_MM apart."""
    closed = np.vstack((loop_mm, loop_mm[:1]))
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))))
    spline = CubicSpline(along, closed, bc_type="periodic")
    return spline(np.linspace(0.0, along[-1], int(along[-1] / OUTLINE_STEP_MM) + 1)[:-1])


def _area(loop_mm: np.ndarray) -> float:
    x, y = loop_mm.T
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def _edge_mm(area_mm2: float, triangles: int) -> float:
    return float(np.sqrt(4.0 / np.sqrt(3.0) * area_mm2 / triangles))
