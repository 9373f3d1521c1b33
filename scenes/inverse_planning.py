"""Plan a target by inverse design into a folder: the Program, its figures, pictures of the search and its end."""

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from planner.calibration import Calibration, load_calibration
from planner.program import PROGRAM_FILE, Machine, layer_figures, load_machine, save_program
from planner.target import Target, save_target
from scenes.checkpoint import inputs_digest
from scenes.output import output_folder, write_json
from scenes.pictures import draw_design, draw_plan, draw_search, draw_target
from scenes.planning import TARGET_FILE
from scenes.prediction import PAPER_SSIM
from scenes.search_folder import opened_search_folder
from twin.inverse import Field, InverseDesign, InverseOptions, Moment, design_inverse


def plan_inverse_into(
    folder: Path,
    target: Target,
    *,
    calibration: Calibration | None = None,
    machine: Machine | None = None,
    options: InverseOptions | None = None,
    resume: Field | None = None,
    progress: Callable[[str, float], None] | None = None,
    watch: Callable[[Moment], None] | None = None,
) -> InverseDesign:
    """Design a Program for `target` and write it into `folder` as `plan_into` does, with progress.png and design.png.

    While it searches, `<folder>.progress` beside `folder` holds current.png and, after the first stage, what to go on
    from; it is removed when the plan is written.

    Args:
        folder: where to write.
        target: the surface.
        calibration: as of `design_inverse`.
        machine: as of `design_inverse`.
        options: as of `design_inverse`.
        resume: as of `design_inverse`.
        progress: called with the stage's name and the share done, 0 to 1.
        watch: called with each step's design.

    Raises:
        InputError: as `design_inverse` does, or if the folder cannot be written.
        SolverError: as `design_inverse` does.
    """
    calibration, machine = calibration or load_calibration(), machine or load_machine()
    options = options or InverseOptions()
    inputs = inputs_digest(target, calibration, options)
    with output_folder(folder) as scratch, opened_search_folder(folder, target, inputs) as searching:

        def watched(moment: Moment) -> None:
            searching.watch(moment)
            if watch is not None:
                watch(moment)

        made = design_inverse(
            target,
            calibration=calibration,
            machine=machine,
            options=options,
            progress=progress,
            watch=watched,
            keep=searching.keep,
            resume=resume,
        )
        save_program(made.program, scratch / PROGRAM_FILE)
        write_json(scratch / "plan.json", inverse_summary(made, options))
        save_target(target, scratch / TARGET_FILE)
        draw_plan(scratch / "plan.png", made.program, machine)
        draw_target(scratch / "target.png", target)
        title = f"{target.name}: inverse design"
        draw_search(scratch / "progress.png", made.history, made.score, title=title, paper_ssim=PAPER_SSIM)
        draw_design(scratch / "design.png", target, made.scored)
    searching.remove()
    return made


def inverse_summary(made: InverseDesign, options: InverseOptions) -> dict[str, Any]:
    """Collect the figures of an inverse design as plain values for `plan.json`."""
    program, record, heated = made.program, made.program.calibration, options.heated
    return {
        "name": program.name,
        "method": program.inputs.method,
        "settings": {
            **program.inputs.settings,
            "budget_s": options.budget_s,
            "temperature_c": heated.temperature_c,
            "support": heated.support,
            "material": asdict(heated.material),
            "mesh_mm": heated.film.mesh_mm,
        },
        "seed": program.seed,
        "target_sha256": program.inputs.target_sha256,
        "program_digest": program.digest,
        "calibration": {"name": record.name, "placeholder": record.placeholder, "provenance": dict(record.provenance)},
        "predicted": asdict(made.score),
        "ideal": asdict(made.ideal),
        "finer_mesh": None if made.finer is None else asdict(made.finer),
        "wider_range_share": made.wider_range_share,
        "noise_costs": made.noise_costs,
        "designed_mm": made.designed_mm,
        "layers": [
            {**figures, "tiling": asdict(tiling)}
            for figures, tiling in zip(layer_figures(program, made.layer_times), made.tilings, strict=True)
        ],
        "problems": [asdict(problem) for problem in made.problems],
        "limits": list(made.limits),
        "notes": list(made.notes),
        "history": [
            {"elapsed_s": moment.elapsed_s, "stage": moment.stage, "ssim": moment.ssim, "rms_mm": moment.rms_mm}
            for moment in made.history
        ],
    }
