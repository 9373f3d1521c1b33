"""One session of a run in its folder: preflight, journal, rig, executor; then everything is given back."""

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from planner.errors import InputError
from planner.program import Problem, Program, check
from planner.program.as_run import AS_RUN_FILE
from rig.assembly import Wrap, logged_in, open_rig
from rig.devices import Operator
from rig.executor.executor import Executor
from rig.executor.interrupts import Interrupts
from rig.executor.journal import JOURNAL_FILE, Journal, read_journal
from rig.executor.past import Past, read_past
from rig.executor.prompts import AbsentOperator, RecordedOperator, SimulatedOperator, TerminalOperator
from rig.executor.run_log import RunLog, RunTime
from rig.executor.view import Unseen, View
from rig.machine_file import RigDescription
from rig.rig_file import WIRELESS
from rig.virtual.machine import VirtualMachine


@dataclass(frozen=True, kw_only=True)
class Ran:
    """What a session did."""

    run_s: float
    """Time of the machine since the run began [s]."""
    wall_s: float
    """Time of the wall in this session [s]."""
    sessions: int


def preflight(program: Program, rig: RigDescription) -> tuple[Problem, ...]:
    """Return the preflight's warnings, and what of a real rig is not there.

    Raises:
        InputError: with every reason why the machine must not run the Program.
    """
    problems = check(program, rig.machine)
    errors = [f"{problem.where}: {problem.message}" for problem in problems if problem.severity == "error"]
    errors += _balance_on_film(program, rig)
    if errors:
        raise InputError(errors)
    return (*problems, *_not_there(rig))


def _not_there(rig: RigDescription) -> list[Problem]:
    """Tell of simulated devices beside real ones, which are seen done although nobody does it."""
    if not rig.file.has_serial_lines:
        return []
    missing = [name for name in WIRELESS if getattr(rig.file, name) == "simulated"]
    told = {"enclosure": "it always says that it is closed, so that nothing guards the UV light"}
    return [
        Problem(
            severity="warning",
            where=f"rig, {name}",
            message=f"is simulated beside real devices: {told.get(name, 'it does nothing')}; set it to operator",
        )
        for name in missing
    ]


def _balance_on_film(program: Program, rig: RigDescription) -> list[str]:
    """Refuse to weigh the post where the film lies."""
    place = rig.file.balance_line
    if rig.file.balance == "none" or place is None:
        return []
    ends = [(min(axis), max(axis)) for axis in zip(*program.film.outline_mm, strict=True)]
    if not all(low <= at <= high for at, (low, high) in zip(place.at_mm, ends, strict=True)):
        return []
    (left, right), (front, back) = ends
    return [
        f"balance_line.at_mm: ({place.at_mm[0]:g}, {place.at_mm[1]:g}) lies on the film, which covers x {left:g} to "
        f"{right:g} and y {front:g} to {back:g} mm; move the balance or the film"
    ]


def open_past(folder: Path, program: Program, rig: RigDescription, *, resume: bool) -> Past:
    """Return what was done in a folder so far.

    Raises:
        InputError: if a run is there and is not to be resumed, or is not there, finished, or another one.
    """
    path = folder / JOURNAL_FILE
    entries = read_journal(path) if path.exists() else []
    begun = any(entry["event"] == "session" for entry in entries)
    if resume and not begun:
        raise InputError(f"--resume: {folder} holds no run that was begun; leave it out")
    if not begun:
        return Past()
    if not resume:
        finished = any(entry.get("record", {}).get("outcome") == "finished" for entry in entries[-1:])
        what = "a finished run; name another folder" if finished else "an unfinished run; go on with it with --resume"
        raise InputError(f"--out: {folder} holds {what}")
    past = read_past(entries, program=program.digest, rig=rig.digest, path=str(path))
    if past.finished:
        raise InputError(f"--resume: the run in {folder} is finished; name another folder to make another film")
    return past


def operator_for(rig: RigDescription, interrupts: Interrupts) -> Operator:
    """Return who answers: somebody at the terminal, or nobody; a rig with nothing real in it needs no one."""
    if rig.file.is_simulated:
        return SimulatedOperator(interrupts)
    return TerminalOperator(interrupts) if sys.stdin.isatty() else AbsentOperator()


def run_session(
    program: Program,
    rig: RigDescription,
    folder: Path,
    *,
    resume: bool = False,
    operator: Operator | None = None,
    view: View | None = None,
    interrupts: Interrupts | None = None,
    wrap: Wrap | None = None,
    virtual: VirtualMachine | None = None,
    utc_s: Callable[[], float] = time.time,
) -> Ran:
    """Run a Program into a folder, or go on with it.

    Args:
        program: what to run.
        rig: the machine.
        folder: where journal, logs and wire logs go; made if absent.
        resume: whether to go on with the run that is there.
        operator: who answers; None: whom the rig needs.
        view: who looks on.
        interrupts: how it is stopped; None: not at all.
        wrap: what is put around each line; None: its log.
        virtual: simulated parts that were there before.
        utc_s: the date [s].

    Raises:
        InputError: if the preflight fails, or the folder does not fit; nothing was opened then.
        RigError: if a device or a file failed, or somebody stopped or paused it.
    """
    begun_s = time.monotonic()
    preflight(program, rig)
    past = open_past(folder, program, rig, resume=resume)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"--out: {folder} cannot be made ({error.strerror}); name another folder") from None
    journal = Journal(folder / JOURNAL_FILE)
    try:
        past = open_past(folder, program, rig, resume=resume)  # now that nobody else writes it
        interrupts = interrupts or Interrupts()
        view = view or Unseen()
        who = RecordedOperator(operator or operator_for(rig, interrupts), view)
        opened = open_rig(
            rig,
            who,
            wrap=wrap or logged_in(folder),
            load=past.load if past.load is not None else 0.0,
            virtual=virtual,
        )
        try:
            log = RunLog(journal, folder / AS_RUN_FILE, past, program, RunTime(opened.devices.clock, past, utc_s=utc_s))
            who.log = log
            executor = Executor(
                program=program,
                rig=rig,
                devices=opened.devices,
                log=log,
                past=past,
                interrupts=interrupts,
                view=view,
            )
            try:
                executor.run()
            finally:
                log.close()
            return Ran(run_s=log.time.now_s(), wall_s=time.monotonic() - begun_s, sessions=past.sessions + 1)
        finally:
            opened.close()
    finally:
        journal.close()
