"""Runs a Program's operations one after the other, each journalled before and verified after."""

from contextlib import nullcontext, suppress
from dataclasses import replace
from datetime import UTC, datetime
from importlib.metadata import version
from typing import Any

from planner.errors import LceError, RigError
from planner.program import Pass, Program
from planner.program.as_run import AsRunEnd, AsRunOperation, AsRunSession, Outcome
from rig.devices import Sighting
from rig.executor.interlocks import Guard
from rig.executor.interrupts import Interrupts, PausedError, StoppedError
from rig.executor.machine import Devices
from rig.executor.operations import LoadChange, Operation, list_operations
from rig.executor.past import Past
from rig.executor.perform import Measured, Performer
from rig.executor.resume import DISTURBED, Resumption
from rig.executor.run_log import RunLog
from rig.executor.scale import Scale
from rig.executor.view import Moment, Unseen, View
from rig.machine_file import RigDescription

READY = "Is the chamber over the post empty (0 g), the post clear of the film, and nobody's hand in the machine?"
HOME_AGAIN = "Is the post free to rise and to home, and nobody's hand in the machine?"


class Executor:
    """One session of a run.

    Args:
        program: what is run; it passed the preflight.
        rig: the machine and its interlocks.
        devices: opened, and not asked for anything yet.
        log: where everything is written down.
        past: what earlier sessions did.
        interrupts: how a person stops it.
        view: who looks on.
    """

    def __init__(
        self,
        *,
        program: Program,
        rig: RigDescription,
        devices: Devices,
        log: RunLog,
        past: Past,
        interrupts: Interrupts,
        view: View | None = None,
    ) -> None:
        self._program = program
        self._rig = rig
        self._devices = devices
        self._log = log
        self._past = past
        self._interrupts = interrupts
        self._view = view or Unseen()
        self._operations = list_operations(program, rig.machine)
        self._touched = dict(past.touched_s)
        self._warned: set[int] = set()
        self._moment: Moment | None = None
        self._was_stopped = False
        self._unstopped: list[str] = []
        pump, setup = rig.machine.pump, rig.pump_setup()
        guard = Guard(
            devices,
            rig.file.interlocks,
            rig.machine,
            tolerance_g=setup.tolerance_ml / pump.ml_per_g,
            watched="enclosure" not in rig.file.attended,
        )
        self._performer = Performer(
            devices,
            guard,
            rig.machine,
            program.film.outline_mm,
            scale=_scale(rig, devices),
            show=self._show,
            show_temperature=self._show_temperature,
            show_time=self._see,
        )
        self._weighed: set[int] = set()
        """Layers whose load was weighed in this session."""

    def run(self) -> None:
        """Do all operations that are not done yet.

        Whatever happens, the devices are stopped in the end and the log says how it ended.

        Raises:
            PausedError: if it ended between two operations, as somebody wished.
            StoppedError: if it was stopped in the middle of one.
            RigError: if a device failed.
        """
        outcome, message = "failed", ""
        try:
            self._begin()
            for operation in self._operations:
                self._do(operation)
            outcome = "finished"
        except PausedError as error:
            outcome, message = "paused", str(error)
            raise
        except StoppedError as error:
            outcome, message = "stopped", str(error)
            raise
        except LceError as error:
            message = str(error)
            raise
        finally:
            if outcome != "finished":
                self._stop()
            message = "; ".join(text for text in (message, *self._unstopped) if text)
            # The first failure is the one to tell; without its end the journal says that the run was cut off.
            with nullcontext() if outcome == "finished" else suppress(RigError):
                self._log.closed(AsRunEnd(at_s=self._log.time.now_s(), outcome=outcome, message=message))

    def _begin(self) -> None:
        """Take up the machine: with the operator's word, home it, and know its load."""
        again = self._past.sessions > 0
        if not self._devices.operator.confirm(HOME_AGAIN if again else READY):
            raise PausedError("Nothing was begun, since the operator did not say that the machine is ready.")
        if again and (problems := self._devices.switch_off()):  # whatever an earlier session left on
            raise RigError("; ".join(problems))
        with self._interrupts.waiting():
            self._devices.connect()
            self._devices.stage.home()
        resumption = Resumption(self._devices, self._log, self._past, self._operations, self._interrupts)
        resumption.know_load()
        self._log.session(
            AsRunSession(
                number=self._past.sessions + 1,
                at_s=self._log.time.now_s(),
                started_utc=_date(self._log.time.utc_s()),
                software=f"lce-twin {version('lce-twin')}",
                machine=self._rig.machine,
                rig_digest=self._rig.digest,
                simulated=self._rig.file.is_simulated,
                attended=self._rig.file.attended,
                devices=self._devices.identities(),
            )
        )
        with self._interrupts.waiting():
            self._performer.lift()
        self._past = resumption.settle(self._past)
        next_one = next((op for op in self._operations if op.number not in self._past.ended), None)
        if again and next_one is not None:
            with self._interrupts.waiting():
                self._performer.change_load(resumption.load_before(next_one))
                weighed_g = self._performer.weigh()
            if weighed_g is not None:
                self._log.note(f"The load was weighed: {weighed_g:.3f} g.")

    def _do(self, operation: Operation) -> None:
        if operation.number in self._past.ended:
            return
        self._safe_point(operation)
        self._check_life(operation)
        attempt = self._past.attempts.get(operation.number, 0) + 1
        while self._attempt(operation, attempt) == "spoiled":
            if not self._devices.operator.confirm(DISTURBED.format(operation.title)):
                if self._interrupts.wanted == "nothing":  # whose no is an answer: else it is asked again on resume
                    self._log.kept(operation)
                break
            attempt += 1
            if isinstance(operation.step, Pass):  # its load may have changed along it
                with self._interrupts.waiting():
                    self._performer.change_load(operation.step.load_g[0])
        # it is done and written down: a no pauses before the next operation, and does not have it done again
        self._performer.wait_off(operation.step)

    def _attempt(self, operation: Operation, attempt: int) -> Outcome:
        measured = Measured()
        start_s = self._log.begin(operation, attempt, self._devices.audited_load())
        if isinstance(operation.step, Pass) and operation.layer is not None:
            self._touched.setdefault(operation.layer, start_s)
        self._tell(operation)
        try:
            with self._interrupts.waiting():
                self._performer.perform(operation.step, measured, weigh=self._is_first_load(operation))
        except LceError as error:
            measured.outcome = "interrupted" if isinstance(error, StoppedError | PausedError) else "failed"
            measured.facts["note"] = str(error)
            self._stop()  # before anything is written, since the disk may be what failed
            with suppress(RigError):
                self._end(operation, attempt, start_s, measured)
            raise
        self._end(operation, attempt, start_s, measured)
        return measured.outcome

    def _is_first_load(self, operation: Operation) -> bool:
        """Tell whether an operation is the first change of a layer's load in this session, and remember it."""
        if operation.kind != "load" or operation.layer is None or operation.layer in self._weighed:
            return False
        self._weighed.add(operation.layer)
        return True

    def _end(self, operation: Operation, attempt: int, start_s: float, measured: Measured) -> None:
        record = AsRunOperation(
            number=operation.number,
            kind=operation.kind,
            layer=operation.layer,
            pass_number=operation.pass_number,
            attempt=attempt,
            outcome=measured.outcome,
            start_s=start_s,
            end_s=self._log.time.now_s(),
            stroke=measured.stroke,
            **measured.facts,
        )
        self._log.end(record, self._devices.audited_load())

    def _stop(self) -> None:
        if not self._was_stopped:
            self._was_stopped = True
            self._unstopped = self._devices.stop()

    def _safe_point(self, operation: Operation) -> None:
        """Between two operations, with the post lifted: pause here if somebody wishes."""
        if self._interrupts.wanted == "nothing":
            return
        if self._interrupts.wanted == "pause" and self._devices.operator.confirm(
            f"Paused before {operation.title}. Go on?"
        ):
            self._interrupts.wanted = "nothing"
            return
        raise PausedError(f"The run is paused before {operation.title}: repeat the command with --resume to go on.")

    def _check_life(self, operation: Operation) -> None:
        """Watch how long the uncured layer has waited since its first pass."""
        touched_s = None if operation.layer is None else self._touched.get(operation.layer)
        if touched_s is None or operation.layer is None or operation.kind not in ("pass", "load", "cure"):
            return
        age_s, limits = self._log.time.now_s() - touched_s, self._rig.machine.layer
        if age_s > limits.alignment_life_s and operation.layer not in self._warned:
            self._warned.add(operation.layer)
            question = (
                f"The first passes of layer {operation.layer + 1} are {age_s / 60:.0f} min old and their alignment, "
                f"which lasts {limits.alignment_life_s / 60:.0f} min, is gone. Go on all the same?"
            )
            if not self._devices.operator.confirm(question):
                raise PausedError(
                    f"Layer {operation.layer + 1} is older than its alignment lasts: scratch it anew after hot air, or "
                    "resume and say yes."
                )
        elif age_s > limits.budget_s and -1 - operation.layer not in self._warned:
            self._warned.add(-1 - operation.layer)
            text = (
                f"Layer {operation.layer + 1} was first scratched {age_s / 60:.0f} min ago, planned are at most "
                f"{limits.budget_s / 60:.0f} min: its first passes fade a little."
            )
            self._log.note(text)
            self._devices.operator.tell(text)

    def _tell(self, operation: Operation) -> None:
        done = self._past.ended
        left_s = sum(op.expected_s for op in self._operations[operation.number :] if op.number not in done)
        step, audited = operation.step, self._devices.audited_load()
        self._moment = Moment(
            operation=operation,
            count=len(self._operations),
            at_s=self._log.time.now_s(),
            position_mm=None if self._moment is None else self._moment.position_mm,
            load_g=step.load_g if isinstance(step, LoadChange) else None if audited is None else audited.load_g,
            temperature_c=None,
            left_s=left_s,
            pausing=False,
        )
        self._view.begin(self._moment)

    def _show(self, seen: Sighting) -> None:
        self._see(position_mm=seen.position_mm)

    def _show_temperature(self, measured_c: float) -> None:
        self._see(temperature_c=measured_c)

    def _see(self, **seen: Any) -> None:
        if self._moment is None:
            return
        now_s = self._log.time.now_s()
        left_s = max(0.0, self._moment.left_s - (now_s - self._moment.at_s))
        self._moment = replace(
            self._moment, at_s=now_s, left_s=left_s, pausing=self._interrupts.wanted == "pause", **seen
        )
        self._view.move(self._moment)


def _scale(rig: RigDescription, devices: Devices) -> Scale | None:
    if devices.balance is None or rig.file.balance_line is None:
        return None
    return Scale(devices.stage, devices.load, devices.balance, rig.file.balance_line)


def _date(utc_s: float) -> str:
    return datetime.fromtimestamp(utc_s, UTC).isoformat(timespec="seconds")
