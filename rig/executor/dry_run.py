"""A run on no port at all: every operation and every line that would go over a wire, with its time."""

import tempfile
from collections.abc import Callable
from pathlib import Path

from planner.program import Program
from rig.executor.operations import Operation
from rig.executor.prompts import SimulatedOperator
from rig.executor.session import run_session
from rig.executor.view import Moment
from rig.machine_file import RigDescription
from rig.peripherals import Controller
from rig.transport import Clock, Transport

FRAME = 3
"""Bytes behind the data of a pump's packet: two of CRC and the end."""


class ToldTransport:
    """Line whose outgoing bytes are also told, one line each, but for the questions for the status."""

    def __init__(self, name: Controller, line: Transport, say: Callable[[str], None]) -> None:
        self._name = name
        self._line = line
        self._say = say

    @property
    def clock(self) -> Clock:
        """Clock of the line inside."""
        return self._line.clock

    def write(self, data: bytes) -> None:
        """Send and tell bytes."""
        self._line.write(data)
        for text in _texts(data):
            self._say(f"{self.clock.now_s():10.2f} s  {self._name:<5} {text}")

    def read(self, timeout_s: float) -> bytes:
        """Return what has arrived."""
        return self._line.read(timeout_s)

    def close(self) -> None:
        """Give the line back."""
        self._line.close()


class ToldView:
    """Tells each operation as it begins."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say

    def begin(self, moment: Moment) -> None:
        """Tell the operation."""
        operation: Operation = moment.operation
        self._say(
            f"{moment.at_s:10.2f} s  {operation.number + 1}/{moment.count} {operation.title}"
            f" (about {operation.expected_s:.0f} s)"
        )

    def move(self, moment: Moment) -> None:
        """Tell nothing: a dry run is fast."""

    def clear(self) -> None:
        """Nothing is shown."""


def run_dry(program: Program, rig: RigDescription, say: Callable[[str], None]) -> float:
    """Run a Program on the rig's simulation, telling everything, and return how long it would take [s].

    Raises:
        InputError: if the preflight fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        ran = run_session(
            program,
            rig.simulation(),
            Path(folder) / "run",
            operator=SimulatedOperator(),
            view=ToldView(say),
            wrap=lambda name, line: ToldTransport(name, line, say),
        )
    return ran.run_s


def _texts(data: bytes) -> list[str]:
    """Write bytes as text: lines of the stage's controller, the pump's packets without their frame."""
    if data == b"?":
        return []
    bare = data.strip(b"\r")
    if bare[:1] == b"\x02":
        return [bare[2:-FRAME].decode("latin-1")]
    return [part.decode("latin-1").encode("unicode_escape").decode("ascii") for part in data.splitlines() if part]
