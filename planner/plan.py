"""Target -> Program: curvature, flattening, toolpaths and cut line, joined (paper, section 2.3)."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from typing import Any, Literal, get_args

import numpy as np
import shapely

from planner.calibration import Calibration, load_calibration
from planner.curvature import CurvatureField, curvature_field
from planner.errors import InputError
from planner.flattening import Distortion, Flattening, distortion, flatten, locate, map_directions, map_points
from planner.program import (
    Actuate,
    CreatedBy,
    Cut,
    Film,
    Inputs,
    Layer,
    LayerTime,
    Machine,
    Pass,
    Problem,
    Program,
    check,
    layer_figures,
    layer_times,
    load_machine,
)
from planner.target import Target
from planner.toolpaths import (
    LINE_WIDTH_MM,
    MAX_TURN_DEG,
    SIDES,
    STEP_MM,
    CutLine,
    Side,
    SideFigures,
    Tracer,
    aligned_layers,
    cut_line,
    plan_side,
    swept_area,
)

logger = logging.getLogger(__name__)

LAYER_THICKNESS_MM = (0.2, 0.2, 0.2, 0.2)
RIM_MM = 3.0
"""Width of the rectangle deposited around the cut line: room for the scissors."""
FLAT_PER_MM = 1e-4
"""Below this curvature its sign is noise: such points stay unaligned instead of being bent to the widest radius."""
DIGITS = 4


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """A Program and everything that led to it."""

    program: Program
    curvature: CurvatureField
    flattening: Flattening
    distortion: Distortion
    film_points_mm: np.ndarray
    """The curvature field's points on the film [mm], shape [n, 2], float; NaN where the flattening misses one."""
    film_direction_rad: np.ndarray
    """The curvature field's directions on the film, modulo pi [rad], shape [n], float."""
    clamped_tight_share: float
    """Share of points whose bending radius is below the calibration's range (the paper's face: 0.03)."""
    clamped_wide_share: float
    """Share of points whose bending radius is above the calibration's range (the paper's face: 0.41)."""
    sides: dict[Side, SideFigures]
    layer_times: tuple[LayerTime, ...]
    problems: tuple[Problem, ...]
    """Findings of the preflight against the machine."""
    notes: tuple[str, ...]
    """Sentences that the user should see."""


def plan(
    target: Target,
    *,
    method: Literal["perpendicular", "maximum"] = "perpendicular",
    flattening: Literal["arap", "grid"] = "arap",
    tracer: Tracer = "greedy",
    calibration: Calibration | None = None,
    machine: Machine | None = None,
    seed: int = 0,
    layer_thickness_mm: Sequence[float] = LAYER_THICKNESS_MM,
    margin_mm: float = 0.0,
    progress: Callable[[str, float], None] | None = None,
) -> Plan:
    """Plan toolpaths for a target by the paper's three steps.

    Args:
        target: the surface that the hot film should become.
        method: which direction at each point is scratched; see `curvature_field`.
        flattening: how the surface is laid flat; see `flatten`.
        tracer: how passes are laid through the field: `greedy` as in the paper, `dense` to tile it without gaps.
        calibration: post settings to bending radii; None: the placeholder, which is not measured.
        machine: for times and the preflight; None: the paper's machine.
        seed: of the random starting points of passes.
        layer_thickness_mm: bottom first [mm]; the lower half is scratched for convex, the upper half for concave
            parts, and with an odd number the middle layer stays polydomain.
        margin_mm: width of unaligned film left around the patterned region [mm].
        progress: called with the stage's name and the share done, 0 to 1.

    Raises:
        InputError: with every problem found, for wrong settings, or a target that gives no passes.
    """
    thickness = tuple(float(value) for value in layer_thickness_mm)
    _check_settings(thickness, margin_mm, seed, tracer)
    calibration = calibration or load_calibration()
    machine = machine or load_machine()
    report = progress or (lambda stage, share: None)

    report("curvature", 0.0)
    field = curvature_field(target, method=method)
    report("flattening", 0.4)
    flat = flatten(target, method=flattening)
    xy = field.points_mm[:, :2]
    located = locate(flat, xy)
    points = map_points(flat, xy, located=located)
    direction = map_directions(flat, xy, field.direction_rad, located=located)

    report("toolpaths", 0.6)
    rng = np.random.default_rng(seed)
    ordered: dict[Side, tuple[Pass, ...]] = {}
    figures: dict[Side, SideFigures] = {}
    tight = wide = 0
    for side, sign in SIDES.items():
        bends = sign * field.curvature_per_mm > FLAT_PER_MM
        mine = np.flatnonzero(bends & np.isfinite(points).all(axis=1) & np.isfinite(direction))
        stack = (thickness, aligned_layers(len(thickness), side))
        limits = calibration.record.limits
        radius = calibration.strip_radius_mm(1 / field.curvature_per_mm[bends], *stack)
        tight += int((radius < limits.radius_mm_min).sum())
        wide += int((radius > limits.radius_mm_max).sum())
        ordered[side], figures[side] = plan_side(
            side, points[mine], direction[mine], field.curvature_per_mm[mine], rng, calibration, stack, tracer
        )
    if not (ordered["convex"] or ordered["concave"]):
        raise InputError(
            f"target '{target.name}' gives no passes: its curvature is below {FLAT_PER_MM:g} /mm or its patches are "
            f"smaller than a line of {LINE_WIDTH_MM:g} mm; choose a larger or more curved target"
        )

    report("cut line", 0.9)
    cut = cut_line(swept_area([*ordered["convex"], *ordered["concave"]], LINE_WIDTH_MM), margin_mm)
    kept: dict[Side, tuple[Pass, ...]] = {side: _inside(passes, cut) for side, passes in ordered.items()}
    program = Program(
        name=target.name,
        seed=seed,
        created_by=CreatedBy(name="lce-twin", version=version("lce-twin")),
        inputs=Inputs(
            method=method,
            target_name=target.name,
            target_sha256=target.digest,
            settings={
                "flattening": flattening,
                "machine": machine.name,
                "margin_mm": float(margin_mm),
                "max_turn_deg": MAX_TURN_DEG,
                "step_mm": STEP_MM,
                "tracer": tracer,
            },
        ),
        calibration=calibration.record,
        film=Film(
            outline_mm=deposited_outline(cut.line_mm, [*kept["convex"], *kept["concave"]]),
            layer_thickness_mm=thickness,
            line_width_mm=LINE_WIDTH_MM,
            uncut_margin_mm=margin_mm,
        ),
        layers=tuple(
            Layer.of(index, thickness[index], _layer_passes(index, len(thickness), kept))
            for index in range(len(thickness))
        ),
        finish=(Cut(line_mm=program_points(cut.line_mm)), Actuate()),
    )
    report("check", 0.95)
    result = Plan(
        program=program,
        curvature=field,
        flattening=flat,
        distortion=distortion(flat),
        film_points_mm=points,
        film_direction_rad=direction,
        clamped_tight_share=tight / len(field.curvature_per_mm),
        clamped_wide_share=wide / len(field.curvature_per_mm),
        sides=figures,
        layer_times=layer_times(program, machine),
        problems=check(program, machine),
        notes=_notes(target, field, points, calibration, thickness, cut, ordered, kept),
    )
    report("done", 1.0)
    logger.info("%s: %d convex and %d concave passes", target.name, len(kept["convex"]), len(kept["concave"]))
    return result


def plan_summary(plan: Plan) -> dict[str, Any]:
    """Collect the figures of a plan as plain values for `plan.json`."""
    program, record = plan.program, plan.program.calibration
    return {
        "name": program.name,
        "method": program.inputs.method,
        "settings": dict(program.inputs.settings),
        "seed": program.seed,
        "target_sha256": program.inputs.target_sha256,
        "program_digest": program.digest,
        "calibration": {"name": record.name, "placeholder": record.placeholder, "provenance": dict(record.provenance)},
        "sample_points": len(plan.curvature.curvature_per_mm),
        "dropped_at_outline_share": plan.curvature.dropped_share,
        "clamped_tight_share": plan.clamped_tight_share,
        "clamped_wide_share": plan.clamped_wide_share,
        "distortion": asdict(plan.distortion),
        "sides": {
            side: {**asdict(figures), "overlap_share": figures.coverage.overlap} for side, figures in plan.sides.items()
        },
        "layers": layer_figures(program, plan.layer_times),
        "problems": [asdict(problem) for problem in plan.problems],
        "notes": list(plan.notes),
    }


def _check_settings(thickness: tuple[float, ...], margin_mm: float, seed: int, tracer: str) -> None:
    problems = []
    if len(thickness) < 2 or not all(np.isfinite(value) and value > 0 for value in thickness):
        problems.append(
            f"layer_thickness_mm is {list(thickness)}, allowed are two or more positive lengths in mm: one layer "
            "cannot bend itself; give 0.2, 0.2, 0.2, 0.2 as in the paper"
        )
    if not (np.isfinite(margin_mm) and margin_mm >= 0):
        problems.append(
            f"margin_mm is {margin_mm}, allowed is a width of 0 mm or more; give 0 to cut along the pattern"
        )
    if seed < 0:
        problems.append(f"seed is {seed}, allowed is a whole number from 0; choose another")
    if tracer not in get_args(Tracer):
        problems.append(
            f"tracer is '{tracer}', allowed are {' and '.join(get_args(Tracer))}; take greedy for the paper's passes"
        )
    if problems:
        raise InputError(problems)


def _layer_passes(index: int, layers: int, kept: dict[Side, tuple[Pass, ...]]) -> tuple[Pass, ...]:
    return next((passes for side, passes in kept.items() if index in aligned_layers(layers, side)), ())


def _inside(passes: tuple[Pass, ...], cut: CutLine) -> tuple[Pass, ...]:
    """Keep the passes that touch the film that stays."""
    lines = [shapely.LineString(stroke.points_mm) for stroke in passes]
    touching = shapely.intersects(lines, cut.piece)
    return tuple(stroke for stroke, keep in zip(passes, touching, strict=True) if keep)


def deposited_outline(cut_line_mm: np.ndarray, passes: Sequence[Pass]) -> tuple[tuple[float, float], ...]:
    """Return the rectangle to deposit [mm]: RIM_MM around the cut line, shape [k, 2], and all passes."""
    every = np.concatenate([cut_line_mm, *(np.array(stroke.points_mm) for stroke in passes)])
    (left, low), (right, high) = every.min(axis=0) - RIM_MM, every.max(axis=0) + RIM_MM
    return program_points(np.array([(left, low), (right, low), (right, high), (left, high)]))


def program_points(points_mm: np.ndarray) -> tuple[tuple[float, float], ...]:
    """Return points [mm], shape [k, 2], as a Program keeps them."""
    return tuple((x, y) for x, y in np.round(points_mm, DIGITS).tolist())


def _notes(
    target: Target,
    field: CurvatureField,
    points: np.ndarray,
    calibration: Calibration,
    thickness: tuple[float, ...],
    cut: CutLine,
    ordered: dict[Side, tuple[Pass, ...]],
    kept: dict[Side, tuple[Pass, ...]],
) -> tuple[str, ...]:
    notes = list(target.notes)
    record = calibration.record
    if record.placeholder:
        notes.append(
            f"Calibration '{record.name}' is a placeholder: radii follow the published range and trends, not a "
            "measurement."
        )
    if set(thickness) != set(record.strip.layer_thickness_mm):
        notes.append(
            f"The calibration was made with layers of {_listed(record.strip.layer_thickness_mm)} mm, the film has "
            f"{_listed(thickness)} mm: the contraction of a setting is assumed not to depend on thickness."
        )
    flat = int((np.abs(field.curvature_per_mm) <= FLAT_PER_MM).sum())
    if flat:
        notes.append(f"{flat} sample points are flat (curvature below {FLAT_PER_MM:g} /mm) and stay unaligned.")
    missed = int(np.isnan(points).any(axis=1).sum())
    if missed:
        notes.append(f"{missed} sample points lie beyond the flattened mesh's edge and were left out.")
    if cut.lost_pieces:
        gone = sum(len(ordered[side]) - len(kept[side]) for side in ordered)
        notes.append(
            f"{cut.lost_pieces} small patterned pieces ({cut.lost_mm2:.1f} mm2, {gone} passes) are not connected to "
            "the film and were dropped."
        )
    return tuple(notes)


def _listed(values: tuple[float, ...]) -> str:
    return ", ".join(f"{value:g}" for value in values)
