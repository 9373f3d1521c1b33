"""How a run that was cut off is taken up: only between operations, and only with the operator's word."""

from dataclasses import replace

from planner.program import Pass
from planner.program.as_run import AsRunOperation, Outcome
from rig.devices import LoadUnknownError
from rig.executor.interrupts import Interrupts, PausedError
from rig.executor.machine import Devices
from rig.executor.operations import LoadChange, Operation
from rig.executor.past import Past, last_attempts
from rig.executor.run_log import RunLog

DONE = {
    "deposit": "Does the whole layer lie, even?",
    "pass": "Shall it be left as it is, without being scratched again?",
    "cure": "Is the layer cured?",
    "cut": "Is the film cut?",
}
"""Questions whose yes means that an operation counts as done."""
AGAIN = {
    "deposit": "Was the layer wiped off, so that it can be deposited again?",
    "reset_alignment": "Shall the hot air begin anew?",
    "pass": "Shall it be scratched again from its start?",
    "cure": "Shall it be cured again, for the whole time?",
    "cut": "Shall it be cut now?",
    "actuate": "Shall the film be heated again?",
}

DISTURBED = "{} was disturbed. Scratch it again?"


class Resumption:
    """Brings machine and journal together before the first operation of a session."""

    def __init__(
        self, devices: Devices, log: RunLog, past: Past, operations: tuple[Operation, ...], interrupts: Interrupts
    ) -> None:
        self._devices = devices
        self._log = log
        self._past = past
        self._operations = operations
        self._interrupts = interrupts

    def know_load(self) -> None:
        """Find out the load in the chamber, by the pump's counters or after it was emptied.

        Raises:
            PausedError: if it is not known and the chamber is not empty.
            RigError: if the pump fails.
        """
        if self._past.sessions and self._past.load is None:
            why = "The load was never read."
        else:
            try:
                with self._interrupts.waiting():
                    self._devices.load.load_g()
                return
            except LoadUnknownError as error:
                why = str(error)
        question = f"{why} Is the chamber over the post empty now (0 g)?"
        if not self._devices.operator.confirm(question):
            raise PausedError("The load in the chamber is not known: empty the chamber, then resume.")
        with self._interrupts.waiting():
            self._devices.load.prime(0.0)

    def settle(self, past: Past) -> Past:
        """Decide with the operator about the operation that was cut off, and return the past with it decided.

        Raises:
            PausedError: if the operator does not decide.
        """
        begun = past.begun
        if past.spoiled is not None:
            return self._settle_spoiled(past, self._operations[past.spoiled])
        if begun is None:
            return past
        operation = self._operations[begun.number]
        if not begun.ended:
            self._end(operation, begun.attempt, begun.at_s, "interrupted", "cut off")
        if isinstance(operation.step, LoadChange):  # the counters know how far it got
            return replace(past, begun=None)
        ask = self._devices.operator.confirm
        what = f"{operation.title} was cut off."
        again, done = AGAIN[operation.kind], DONE.get(operation.kind)
        # A pass is better scratched twice than not; anything else is asked for the other way round.
        if operation.kind == "pass" and ask(f"{what} {again}"):
            return replace(past, begun=None)
        if done is not None and ask(f"{what} {done}"):
            self._end(operation, begun.attempt, begun.at_s, "left", "by the operator's word")
            return replace(past, begun=None, ended=past.ended | {begun.number})
        if operation.kind != "pass" and ask(f"{what} {again}"):
            return replace(past, begun=None)
        raise PausedError(f"{what} Decide what becomes of it, then resume.")

    def _settle_spoiled(self, past: Past, operation: Operation) -> Past:
        if self._devices.operator.confirm(DISTURBED.format(operation.title)):
            return replace(past, spoiled=None, ended=past.ended - {operation.number})
        self._log.kept(operation)
        return replace(past, spoiled=None)

    def load_before(self, operation: Operation) -> float:
        """Return the load that the Program has in the chamber before an operation [g]."""
        load_g = 0.0
        for before in self._operations[: operation.number]:
            if isinstance(before.step, LoadChange):
                load_g = before.step.load_g
            elif isinstance(before.step, Pass):
                load_g = before.step.load_g[-1]
        return load_g

    def _end(self, operation: Operation, attempt: int, start_s: float, outcome: Outcome, note: str) -> None:
        record = AsRunOperation(
            number=operation.number,
            kind=operation.kind,
            layer=operation.layer,
            pass_number=operation.pass_number,
            attempt=attempt,
            outcome=outcome,
            start_s=start_s,
            end_s=max(start_s, self._past.at_s),
            stroke=self._left_stroke(operation) if outcome == "left" else None,
            note=note,
        )
        self._log.end(record, self._devices.audited_load())

    def _left_stroke(self, operation: Operation) -> Pass | None:
        """Return what of a pass is on the film: what was seen of it, or all if nobody looked, as after a power cut."""
        if not isinstance(operation.step, Pass):
            return None
        seen = last_attempts(self._past.records).get(operation.number)
        return operation.step if seen is None else seen.stroke
