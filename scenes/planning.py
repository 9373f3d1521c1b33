"""Plan a target into a folder: the Program, its figures and picture, and the target itself."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Literal

from planner.calibration import Calibration
from planner.plan import LAYER_THICKNESS_MM, Plan, plan, plan_summary
from planner.program import PROGRAM_FILE, Machine, Program, layer_times, load_machine, save_program
from planner.strips import strip_program
from planner.target import Target, save_target
from planner.toolpaths import Tracer
from scenes.output import output_folder, write_json
from scenes.pictures import draw_plan, draw_target

TARGET_FILE = "target.npz"
PLAN_FILE = "plan.json"


def plan_into(
    folder: Path,
    target: Target,
    *,
    method: Literal["perpendicular", "maximum"] = "perpendicular",
    flattening: Literal["arap", "grid"] = "arap",
    tracer: Tracer = "greedy",
    calibration: Calibration | None = None,
    machine: Machine | None = None,
    layer_thickness_mm: Sequence[float] = LAYER_THICKNESS_MM,
    margin_mm: float = 0.0,
    seed: int = 0,
    progress: Callable[[str, float], None] | None = None,
) -> Plan:
    """Plan `target` and write program.json, plan.json, plan.png, target.npz and target.png into `folder`.

    Arguments as of `planner.plan.plan`.

    Raises:
        InputError: as `plan` does, or if the folder cannot be written.
    """
    with output_folder(folder) as scratch:
        made = plan(
            target,
            method=method,
            flattening=flattening,
            tracer=tracer,
            calibration=calibration,
            machine=machine,
            layer_thickness_mm=layer_thickness_mm,
            margin_mm=margin_mm,
            seed=seed,
            progress=progress,
        )
        save_program(made.program, scratch / PROGRAM_FILE)
        write_json(scratch / PLAN_FILE, plan_summary(made))
        save_target(target, scratch / TARGET_FILE)
        draw_plan(scratch / "plan.png", made.program, machine)
        draw_target(scratch / "target.png", target)
    return made


def plan_strip_into(
    folder: Path,
    calibration: Calibration,
    *,
    name: str,
    length_mm: float,
    width_mm: float,
    radius_mm: float,
    machine: Machine | None = None,
) -> Program:
    """Write the Program of a calibration strip, its figures and its picture into `folder`.

    Arguments and errors as of `planner.strips.strip_program`.
    """
    with output_folder(folder) as scratch:
        program = strip_program(calibration, name=name, length_mm=length_mm, width_mm=width_mm, radius_mm=radius_mm)
        save_program(program, scratch / PROGRAM_FILE)
        first = program.layers[0].passes[0]
        summary = {
            "name": name,
            "method": "strip",
            "radius_mm": radius_mm,
            "load_g": first.load_g[0],
            "speed_mm_s": first.speed_mm_s[0],
            "contraction": calibration.contraction(first.load_g[0], first.speed_mm_s[0]),
            "layer_times_s": [time.total_s for time in layer_times(program, machine or load_machine())],
            "calibration": {"name": calibration.record.name, "placeholder": calibration.record.placeholder},
            "program_digest": program.digest,
        }
        write_json(scratch / PLAN_FILE, summary)
        draw_plan(scratch / "plan.png", program, machine)
    return program
