"""Plan a target into a folder: the Program, its figures and picture, and the target itself."""

from collections.abc import Callable
from pathlib import Path
from typing import Literal

from planner.calibration import Calibration
from planner.plan import Plan, plan, plan_summary
from planner.program import PROGRAM_FILE, Machine, save_program
from planner.target import Target, save_target
from scenes.output import output_folder, write_json
from scenes.pictures import draw_plan, draw_target

TARGET_FILE = "target.npz"


def plan_into(
    folder: Path,
    target: Target,
    *,
    method: Literal["perpendicular", "maximum"] = "perpendicular",
    flattening: Literal["arap", "grid"] = "arap",
    calibration: Calibration | None = None,
    machine: Machine | None = None,
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
            calibration=calibration,
            machine=machine,
            margin_mm=margin_mm,
            seed=seed,
            progress=progress,
        )
        save_program(made.program, scratch / PROGRAM_FILE)
        write_json(scratch / "plan.json", plan_summary(made))
        save_target(target, scratch / TARGET_FILE)
        draw_plan(scratch / "plan.png", made.program, machine)
        draw_target(scratch / "target.png", target)
    return made
