"""`lce run`: a Program on a rig into a folder, and what the film is worth in the end."""

import os
import shutil
import sys
from contextlib import suppress
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

from planner.errors import LceError
from planner.program import Program, layer_times, load_program
from planner.program.as_run import AS_RUN_FILE, ENDED, AsRunOperation, AsRunSession
from planner.program.as_run_film import load_as_run, read_as_run
from planner.target import Target
from rig.executor.dry_run import run_dry
from rig.executor.interrupts import Interrupts
from rig.executor.operations import list_operations
from rig.executor.session import Ran, preflight, run_session
from rig.machine_file import RigDescription, load_rig
from scenes.as_run_score import AsRunScores, score_as_run
from scenes.commands import say
from scenes.live_view import live_view
from scenes.output import write_json
from scenes.plan_folder import plans_target
from scenes.planning import TARGET_FILE
from scenes.whole_file import whole_file


def run_program(program: Path, out: Path, *, rig: Path | None, dry_run: bool, resume: bool, score: bool) -> None:
    """Run a Program, or say what running it would be.

    Raises:
        InputError: if an input is wrong; then no port was opened.
        RigError: if the rig failed or was stopped.
    """
    loaded, description = load_program(program), load_rig(rig)
    for problem in preflight(loaded, description):
        say(f"{problem.severity}: {problem.where}: {problem.message}")
    if dry_run:
        run_s = run_dry(loaded, description, _say_while_read)
        say(f"dry run: {run_s / 60:.0f} min; nothing was opened, nothing was written")
        return
    target = plans_target(program, loaded.inputs.target_sha256)
    interrupts = Interrupts()
    try:
        with interrupts.from_signals(), live_view() as view:
            ran = run_session(loaded, description, out, resume=resume, view=view, interrupts=interrupts)
    except LceError as error:
        if (out / AS_RUN_FILE).exists():
            with suppress(OSError, LceError):  # the first failure is the one to tell
                _write_summary(out, loaded, description, None, None, message=str(error))
        raise
    _write_summary(out, loaded, description, ran, None)  # scoring takes minutes and may be interrupted
    if target is not None:
        planned = (program if program.is_dir() else program.parent) / TARGET_FILE
        if planned.resolve() != (out / TARGET_FILE).resolve():
            shutil.copyfile(planned, out / TARGET_FILE)
    say(f"run of {ran.run_s / 60:.0f} min finished in {ran.wall_s:.0f} s of wall time, {ran.sessions} session(s)")
    scores = _score(out, target) if score and target is not None else None
    if scores is not None:
        _write_summary(out, loaded, description, ran, scores)
    say(f"logs written to {out}, start with {out / 'run.json'}")


def _say_while_read(text: str) -> None:
    """Say a line, unless the reader of the pipe has gone, as `head` does."""
    try:
        say(text)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _score(out: Path, target: Target) -> AsRunScores:
    film = load_as_run(out / AS_RUN_FILE)
    for note in film.notes:
        say(f"note: {note}")
    scores = score_as_run(film, target)
    say(f"SSIM (Eq. 4) {scores.planned.ssim_eq4:.3f} as planned, {scores.as_run.ssim_eq4:.3f} as run")
    return scores


def _touch_to_cure_s(done: list[AsRunOperation], layer: int) -> float | None:
    """Return the time from the first pass of a layer to its cure [s]; None if one of them was not done."""
    touched = [record.start_s for record in done if record.layer == layer and record.kind == "pass"]
    cured = [record.start_s for record in done if record.layer == layer and record.kind == "cure"]
    return cured[-1] - touched[0] if touched and cured else None


def _write_summary(
    out: Path, program: Program, rig: RigDescription, ran: Ran | None, scores: AsRunScores | None, *, message: str = ""
) -> None:
    planned = layer_times(program, rig.machine)
    records = read_as_run(out / AS_RUN_FILE)
    done = [record for record in records if isinstance(record, AsRunOperation)]
    sessions = [record for record in records if isinstance(record, AsRunSession)]
    summary: dict[str, Any] = {
        "finished": ran is not None,
        "message": message,
        "program_name": program.name,
        "program_digest": program.digest,
        "rig_digest": rig.digest,
        "simulated": rig.file.is_simulated,
        "run_s": None if ran is None else ran.run_s,
        "wall_s": None if ran is None else ran.wall_s,
        "sessions": len(sessions),
        "devices": sessions[-1].devices if sessions else {},
        "operations": len(list_operations(program, rig.machine)),
        "operations_ended": len({record.number for record in done if record.outcome in ENDED}),
        "attempts_again": sum(record.attempt > 1 for record in done),
        "not_as_planned": [
            f"operation {record.number}, attempt {record.attempt}: {record.outcome}; {record.note}"
            for record in done
            if record.outcome != "done"
        ],
        "planned_scratching_s": [time.total_s for time in planned],
        "first_touch_to_cure_s": [_touch_to_cure_s(done, layer.index) for layer in program.layers],
        "score_planned": None if scores is None else asdict(scores.planned),
        "score_as_run": None if scores is None else asdict(scores.as_run),
        "version": version("lce-twin"),
    }
    with whole_file(out / "run.json") as path:
        write_json(path, summary)
