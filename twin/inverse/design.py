"""Inverse design: a Program whose film becomes the target (paper, sections 2.3 and 3: left for future work).

Coarse to fine, each stage starting from the last one's film:

1. at the target: flat film and alignment with the least energy when bent into it, without solving for equilibrium;
2. coarse: through the equilibrium under weight and plate, in the basin that the ramp from flat finds;
3. middle: the same on a finer mesh;
4. lines through the fields, a load for each pass;
5. passes: the speeds along them, through the film that they really make;
6. finish: the same on the mesh of the check, in the basin that the ramp finds there;
7. check: the Program heated from flat, as `lce predict` does.
"""

import logging
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from importlib.metadata import version

import numpy as np

from planner.calibration import Calibration, load_calibration
from planner.plan import deposited_outline, program_points
from planner.program import (
    Actuate,
    CreatedBy,
    Cut,
    Inputs,
    Layer,
    LayerTime,
    Machine,
    Pass,
    Problem,
    Program,
    check,
    layer_times,
    load_machine,
)
from planner.program import Film as DepositedFilm
from planner.target import Target
from planner.toolpaths.dense import Tiling
from twin.equilibrium import rigid_distance_mm
from twin.film import carry
from twin.hot_shape import HotShape
from twin.inverse.limits import STRONGER, describe_limits, scaled
from twin.inverse.noise_costs import noise_costs
from twin.inverse.options import InverseOptions
from twin.inverse.search import Moment, Search
from twin.inverse.stages import Field, Stages
from twin.predict import heat_film, predict
from twin.score import Score, Scored, score_surface

logger = logging.getLogger(__name__)

FINER = 0.8
"""Edges of the mesh that shows what the mesh is worth, over those of the mesh that the design was made on."""


@dataclass(frozen=True, kw_only=True, eq=False)
class InverseDesign:
    """A Program, what it is predicted to become, and how it was found."""

    program: Program
    shape: HotShape
    """The Program's film heated from flat."""
    scored: Scored
    """Its score, with the errors that it was measured on."""
    ideal: Score
    """Score of the smooth fields without passes, heated from flat likewise: what the passes cost."""
    finer: Score | None
    """Score of the Program on a mesh with edges of `FINER` times the length: what the mesh is worth; None where the
    budget of time left no room for it."""
    wider_range_share: float | None
    """Elastic energy that the best flat film keeps at the target if contractions could be `STRONGER` times as large,
    over what it keeps as it is: below 1 as far as the range of contractions is what limits the design; None where the
    budget of time left no room for it."""
    noise_costs: dict[str, float] | None
    """What errors of the process cost by the film's answer to first order, see `twin.inverse.noise_costs`; None
    where the equilibrium is not stable, or the budget of time left no room for it."""
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

    @property
    def score(self) -> Score:
        """What the Program is predicted to reach."""
        return self.scored.score


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
    search = Search(options.budget_s, progress, watch)
    stages = Stages(target, calibration, options, search)
    keep = keep or (lambda field: None)
    field = resume
    if field is None:
        search.report("first design", 0.0)
        field = stages.coarse()
        keep(field)
    weights = stages.weights_after(field)
    if field.stage == "coarse":
        field = stages.middle(field, weights.pop(0))
        keep(field)
    while True:
        search.report("lines", 0.0)
        traced = stages.lines(field, machine)
        designed, landed = stages.passes(field, traced)
        time_left = search.time_for("passes")
        again = bool(weights) and time_left
        if time_left and (landed or not again):
            designed, landed = stages.finish(field, designed, recover=not again)
        if landed or not again or not search.time_for("passes"):
            break
        logger.info("the passes snap on their way from flat: fields with more weight on the anchor")
        field = stages.middle(field, weights.pop(0))
        keep(field)
    program = _program(target, calibration, machine, options, field.outline_mm, designed.layers)
    search.report("check", 0.0)
    shape = predict(program, options.heated, progress=lambda stage, share: search.report("check", share))
    scored = score_surface(shape.top_mm, shape.film.triangles, target)
    meant = carry(designed.flat_mm, designed.vertices_mm, shape.film.flat_mm)
    ideal = stages.ideal_film(field)
    in_time = search.time_for("limits")

    @cache
    def left_over(size: float, thickness: float, contraction: float) -> float:
        first = stages.at_target(scaled(target, size), thickness=thickness, contraction=contraction)
        return first.energy_mm / (thickness * sum(options.layer_thickness_mm))

    return InverseDesign(
        program=program,
        shape=shape,
        scored=scored,
        ideal=score_surface(heat_film(ideal, options.heated).top_mm, ideal.triangles, target).score,
        finer=_finer_score(program, options, target) if in_time else None,
        wider_range_share=left_over(1.0, 1.0, STRONGER) / left_over(1.0, 1.0, 1.0) if in_time else None,
        noise_costs=noise_costs(shape.film, shape.hot_mm, target, options.noise, options.heated) if in_time else None,
        designed_mm=rigid_distance_mm(shape.hot_mm, meant),
        tilings=tuple(layer.tiling for layer in traced),
        layer_times=layer_times(program, machine),
        problems=check(program, machine),
        history=tuple(search.history),
        notes=tuple(target.notes),
        limits=describe_limits(target, scored, shape.film, stages.largest, left_over if in_time else None),
    )


def _finer_score(program: Program, options: InverseOptions, target: Target) -> Score:
    film = replace(options.heated.film, mesh_mm=FINER * options.heated.film.mesh_mm)
    shape = predict(program, replace(options.heated, film=film))
    return score_surface(shape.top_mm, shape.film.triangles, target).score


def _noise_settings(options: InverseOptions) -> dict[str, float | str]:
    """Return what a robust design was made to bear."""
    return {f"noise_{name}": value for name, value in options.noise.plain().items()} if options.robust else {}


def _program(
    target: Target,
    calibration: Calibration,
    machine: Machine,
    options: InverseOptions,
    outline_mm: np.ndarray,
    layers: Sequence[Sequence[Pass]],
) -> Program:
    every = [stroke for passes in layers for stroke in passes]
    return Program(
        name=target.name,
        seed=options.seed,
        created_by=CreatedBy(name="lce-twin", version=version("lce-twin")),
        inputs=Inputs(
            method="inverse",
            target_name=target.name,
            target_sha256=target.digest,
            settings={
                "machine": machine.name,
                "stack": options.stack,
                "robust": options.robust,
                **_noise_settings(options),
                "temperature_c": options.heated.temperature_c,
                "support": options.heated.support,
                **asdict(options.heated.material),
            },
        ),
        calibration=calibration.record,
        film=DepositedFilm(
            outline_mm=deposited_outline(outline_mm, every),
            layer_thickness_mm=options.layer_thickness_mm,
            line_width_mm=options.line_width_mm,
        ),
        layers=tuple(
            Layer.of(index, thickness, tuple(passes))
            for index, (thickness, passes) in enumerate(zip(options.layer_thickness_mm, layers, strict=True))
        ),
        finish=(Cut(line_mm=program_points(outline_mm)), Actuate(temperature_c=options.heated.temperature_c)),
    )
