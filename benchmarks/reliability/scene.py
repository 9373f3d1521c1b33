"""One run with one fault in it: what the fault may reach, and how the run ends."""

import errno
import json
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any
from unittest import mock

from benchmarks.reliability.small_run import AREA_MM2, small_program, small_rig
from benchmarks.reliability.truth import Truth
from planner.errors import LceError
from planner.program.as_run import AS_RUN_FILE, ENDED
from rig.executor.interrupts import Interrupts
from rig.executor.journal import Journal
from rig.executor.operations import list_operations
from rig.executor.session import run_session
from rig.executor.view import Moment
from rig.peripherals import Controller
from rig.transport import Clock, Fault, FaultyTransport, Transport, VirtualClock
from rig.virtual.machine import VirtualMachine

SESSIONS = 5
LONGEST_S = 6 * 3600.0
"""Machine time after which a session counts as hung [s]; the small run takes five minutes."""
WALL_S = 120


class HungError(BaseException):
    """A session did not end."""


class KilledError(BaseException):
    """The host is gone: from now on it neither says nor writes anything."""


class BoundedClock(VirtualClock):
    """Virtual time that ends."""

    limit_s = LONGEST_S

    def advance_to(self, time_s: float) -> None:
        """Let it become a time [s]."""
        super().advance_to(time_s)
        if self._now_s > self.limit_s:
            raise HungError("machine time")


class ArmedLine:
    """Line that can be made faulty at any moment."""

    def __init__(self, line: Transport) -> None:
        self.cut = False
        """Whether there is no host any more."""
        self._line = line
        self.change_in: Callable[[bytes], bytes] | None = None
        """Applied to what is read until it changes something."""

    @property
    def clock(self) -> Clock:
        return self._line.clock

    def arm(self, fault: Fault) -> None:
        """Let a fault happen, its byte counted from now on."""
        self._line = FaultyTransport(self._line, [fault])

    def write(self, data: bytes) -> None:
        if self.cut:
            raise KilledError
        self._line.write(data)

    def read(self, timeout_s: float) -> bytes:
        if self.cut:
            raise KilledError
        data = self._line.read(timeout_s)
        if data and self.change_in is not None and (changed := self.change_in(data)) != data:
            self.change_in = None
            return changed
        return data

    def close(self) -> None:
        self._line.close()


class Someone:
    """Operator who says yes, unless told otherwise; empties the chamber when asked whether it is empty."""

    name = "someone"

    def __init__(self, scene: "Scene") -> None:
        self.refusals = 0
        self._scene = scene

    def confirm(self, question: str) -> bool:
        if self.refusals:
            self.refusals -= 1
            return False
        if "empty now" in question:
            plunger = self._scene.machine.pump.plunger
            plunger.moved_ml = plunger.water_ml = 0.0
        return True

    def tell(self, text: str) -> None: ...


@dataclass(frozen=True, kw_only=True)
class Ended:
    """How a run with a fault in it ended."""

    finished: bool
    told: tuple[str, ...]
    """Why sessions ended early, one sentence each."""
    wrong: tuple[str, ...]
    """What the run believed and was not so: silent failures."""
    twice: tuple[int, ...]
    """Operations that the as-run log has as ended more than once."""
    missing: tuple[int, ...]
    """Operations that it lacks."""
    hung: bool


class Scene:
    """A small run, its machine and whatever else a fault may reach."""

    def __init__(self, folder: Path, arm: Callable[["Scene"], None], stage: int) -> None:
        self.folder = folder
        self.machine = VirtualMachine(small_rig(), BoundedClock())
        self.lines: dict[Controller, ArmedLine] = {}
        self.interrupts = Interrupts()
        self.operator = Someone(self)
        self.later_s = 0.0
        """By how much the date is wrong [s]."""
        self.on_move: list[Callable[[], None]] = []
        """What happens at the next sightings of the moving stage, one each."""
        self.repairs: list[Callable[[], None]] = []
        """What is put right before the run is resumed, one thing for each session."""
        self.disk_full = False
        self._arm: Callable[[Scene], None] | None = arm
        self._stage = stage
        self._operations = list_operations(small_program(), small_rig().machine)
        self._truth = Truth(self.machine, small_rig(), self._operations, area_mm2=AREA_MM2)

    def kill(self) -> None:
        """Let the host die, with everything under way on the machine."""
        self._truth.forget()
        for line in self.lines.values():
            line.cut = True
        raise KilledError

    @property
    def now_s(self) -> float:
        return self.machine.clock.now_s()

    def begin(self, moment: Moment) -> None:
        self._truth.begin(moment)
        if self._arm is not None and moment.operation.number >= self._stage:
            arm, self._arm = self._arm, None
            arm(self)

    def move(self, moment: Moment) -> None:
        if self.on_move:
            self.on_move.pop(0)()

    def clear(self) -> None: ...

    def run(self) -> Ended:
        """Run, and resume until it is finished or nothing helps."""
        told: list[str] = []
        finished = hung = False
        with _alarm():
            for session in range(SESSIONS):
                try:
                    self._session(resume=session > 0 and self._has_begun())
                    self._truth.check_done()
                    finished = True
                    break
                except LceError as error:
                    told.append(str(error))
                    self._truth.forget()
                    self._repair()
                except KilledError:
                    told.append("killed")
                    self._truth.forget()
                    self._repair()
                except HungError:
                    hung = True
                    break
        counts = self._counts()
        return Ended(
            finished=finished,
            told=tuple(told),
            wrong=tuple(self._truth.wrong),
            twice=tuple(number for number, count in counts.items() if count > 1),
            missing=tuple(number for number, count in counts.items() if not count) if finished else (),
            hung=hung,
        )

    def _session(self, *, resume: bool) -> None:
        self.machine.clock.limit_s = self.now_s + LONGEST_S  # pyright: ignore[reportAttributeAccessIssue]
        self.lines.clear()
        full = OSError(errno.ENOSPC, "No space left on device")

        written = Journal.write

        def write(journal: Journal, entry: dict[str, Any]) -> None:
            if any(line.cut for line in self.lines.values()):
                raise KilledError
            written(journal, entry)

        def fsync(_: int) -> None:
            if self.disk_full:
                raise full

        with mock.patch("rig.executor.journal.os.fsync", fsync), mock.patch.object(Journal, "write", write):
            run_session(
                small_program(),
                small_rig(),
                self.folder,
                resume=resume,
                operator=self.operator,
                view=self,
                interrupts=self.interrupts,
                wrap=self._wrap,
                virtual=self.machine,
                utc_s=lambda: 1e9 + self.now_s + self.later_s,
            )

    def _wrap(self, name: Controller, line: Transport) -> Transport:
        self.lines[name] = ArmedLine(line)
        return self.lines[name]

    def _repair(self) -> None:
        """Put right what any operator would before a run is resumed; the rest is up to the fault."""
        self.interrupts.wanted = "nothing"
        self.disk_full = False
        self.on_move.clear()
        self.machine.clock.sleep(5.0)
        if self.repairs:
            self.repairs.pop(0)()

    def _has_begun(self) -> bool:
        path = self.folder / "journal.jsonl"
        return path.exists() and b'"event":"session"' in path.read_bytes()

    def _counts(self) -> dict[int, int]:
        counts = dict.fromkeys(range(len(self._operations)), 0)
        records = [record for record in as_run_records(self.folder) if record["record"] == "operation"]
        for place, record in enumerate(records):
            # A disturbed stroke that was done again as the operator wished is followed by its next attempt.
            redone = record["outcome"] == "spoiled" and any(
                later["number"] == record["number"] for later in records[place + 1 :]
            )
            counts[record["number"]] += record["outcome"] in ENDED and not redone
        return counts


def as_run_records(folder: Path) -> list[dict[str, Any]]:
    """Return the records of a run's log."""
    path = folder / AS_RUN_FILE
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


@contextmanager
def _alarm() -> Iterator[None]:
    """Count wall time as well: a loop without waits never ends by the machine's clock."""

    def ring(_: int, frame: FrameType | None) -> None:
        raise HungError(f"wall time, at {frame}")

    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(WALL_S)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
