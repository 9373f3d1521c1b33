"""Everything that is written down of a run: the journal first, then the as-run log, which is made from it."""

import logging
import os
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from planner.errors import RigError
from planner.program import Program
from planner.program.as_run import (
    AsRunAnswer,
    AsRunEnd,
    AsRunNote,
    AsRunOperation,
    AsRunProgram,
    AsRunRecord,
    AsRunSession,
)
from rig.executor.journal import Journal
from rig.executor.operations import Operation
from rig.executor.past import Past, load_to
from rig.pump_load import AuditedLoad
from rig.transport import Clock

_log = logging.getLogger(__name__)


class RunTime:
    """Time since a run began [s], sessions and the breaks between them added up; it never goes back.

    The date is only asked for the length of a break. Set forward it makes the layers seem older, which is told to
    the operator; set back it counts as no break.
    """

    def __init__(self, clock: Clock, past: Past, *, utc_s: Callable[[], float] = time.time) -> None:
        self._clock = clock
        self.utc_s = utc_s
        break_s = max(0.0, utc_s() - past.utc_s) if past.sessions else 0.0
        self._start_s = past.at_s + break_s - clock.now_s()

    def now_s(self) -> float:
        """Return the time since the run began [s]."""
        return self._start_s + self._clock.now_s()


class RunLog:
    """Writes each event into the journal, on the disk, and then into the as-run log, which follows from it."""

    def __init__(self, journal: Journal, as_run: Path, past: Past, program: Program, run_time: RunTime) -> None:
        """Write the as-run log anew from the past, so that it lacks nothing that the journal has.

        Raises:
            RigError: if it cannot be written.
        """
        self._journal = journal
        self._program_digest = program.digest
        self.time = run_time
        first = AsRunProgram(program=program, digest=program.digest)
        try:
            partial = as_run.with_name(f".{as_run.name}")
            with partial.open("w", encoding="utf-8") as file:
                file.writelines(record.model_dump_json() + "\n" for record in (first, *past.records))
                file.flush()
                os.fsync(file.fileno())
            partial.replace(as_run)
            self._as_run = as_run.open("a", encoding="utf-8", buffering=1)
        except OSError as error:
            raise RigError(f"As-run log {as_run} cannot be written ({error.strerror}): name another folder.") from error

    def session(self, record: AsRunSession) -> None:
        """Begin a session."""
        self._write("session", record, {"program": self._program_digest, "rig": record.rig_digest})

    def begin(self, operation: Operation, attempt: int, load: AuditedLoad | None) -> float:
        """Write down that an operation is about to be done, and return the time [s].

        Raises:
            RigError: if it cannot be written: then it must not be begun.
        """
        at_s = self.time.now_s()
        touches = operation.layer if operation.kind == "pass" else None
        self._journal.write(
            {
                "event": "begin",
                "op": operation.number,
                "attempt": attempt,
                "touches": touches,
                "at_s": at_s,
                "utc_s": self.time.utc_s(),
                "load": load_to(load),
            }
        )
        return at_s

    def end(self, record: AsRunOperation, load: AuditedLoad | None) -> None:
        """Write down how an operation ended."""
        self._write("end", record, {"op": record.number, "load": load_to(load)})

    def kept(self, operation: Operation) -> None:
        """Write down that a disturbed stroke is left as it is, by the operator's word."""
        self._journal.write(
            {"event": "kept", "op": operation.number, "at_s": self.time.now_s(), "utc_s": self.time.utc_s()}
        )

    def answer(self, question: str, *, yes: bool, by: str) -> None:
        """Write down what the operator answered."""
        self._write("answer", AsRunAnswer(at_s=self.time.now_s(), question=question, yes=yes, by=by))

    def note(self, text: str) -> None:
        """Write down something else."""
        self._write("note", AsRunNote(at_s=self.time.now_s(), text=text))

    def load(self, load: AuditedLoad | None) -> None:
        """Write down what the pump's counters say."""
        self._journal.write(
            {"event": "load", "load": load_to(load), "at_s": self.time.now_s(), "utc_s": self.time.utc_s()}
        )

    def closed(self, record: AsRunEnd) -> None:
        """End the session."""
        self._write("closed", record)

    def close(self) -> None:
        """Give the files back."""
        self._journal.close()
        with suppress(OSError):  # a full disk was told when it was written; the log is written anew from the journal
            self._as_run.close()

    def _write(self, event: str, record: AsRunRecord, more: dict[str, Any] | None = None) -> None:
        dumped = record.model_dump(mode="json")
        times = {"at_s": self.time.now_s(), "utc_s": self.time.utc_s()}
        self._journal.write({"event": event, **times, **(more or {}), "record": dumped})
        try:
            self._as_run.write(record.model_dump_json() + "\n")
        except OSError as error:
            # The journal has it, and the log is written anew from there.
            _log.warning("as-run log is behind the journal: %s", error)
            raise RigError(f"As-run log cannot be written ({error.strerror}): free the disk, then resume.") from error
