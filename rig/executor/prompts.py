"""The operator: at a terminal, absent, simulated; and what was asked and answered is written down."""

import os
import select
import sys
import termios
import time
from contextlib import suppress

from rig.devices import Operator
from rig.executor.interrupts import Interrupts
from rig.executor.run_log import RunLog
from rig.executor.view import View

TRIES = 3
PATIENCE_S = 3600.0
"""Silence after which a question counts as answered by no [s]; nothing moves, shines or heats meanwhile."""


class TerminalOperator:
    """Somebody at the terminal; only a clear yes is one."""

    name = "operator"

    def __init__(self, interrupts: Interrupts | None = None, *, patience_s: float = PATIENCE_S) -> None:
        """Ask until somebody answers, or wishes by Ctrl-C to pause or to stop, which is no answer."""
        self._interrupts = interrupts or Interrupts()
        self._patience_s = patience_s
        self._typed = b""

    def confirm(self, question: str) -> bool:
        """Ask, and return whether `y` or `yes` was answered; nothing, silence and three unclear answers are no."""
        # What was typed before was no answer to this.
        with suppress(termios.error):
            termios.tcflush(sys.stdin.fileno(), termios.TCIFLUSH)
        self._typed = b""
        for _ in range(TRIES):
            _write(f"{question} [y/N]")  # a whole line, so that the live view lets it pass
            answer = self._line()
            if answer is None or answer in ("", "n", "no"):
                return False
            if answer in ("y", "yes"):
                return True
            self.tell(f"{answer!r} is neither yes nor no: answer y or n.")
        return False

    def tell(self, text: str) -> None:
        """Write a line."""
        _write(text)

    def _line(self) -> str | None:
        # Read without the stream's buffer, in which a second line would hide from `select`.
        terminal, end_s = sys.stdin.fileno(), time.monotonic() + self._patience_s
        wanted = self._interrupts.wanted
        while b"\n" not in self._typed and time.monotonic() < end_s:
            readable, _, _ = select.select([terminal], [], [], 0.2)
            if self._interrupts.wanted not in (wanted, "nothing") or self._interrupts.wanted == "stop":
                return None
            if readable:
                data = os.read(terminal, 1024)
                if not data:
                    return None
                self._typed += data
        line, end, self._typed = self._typed.partition(b"\n")
        if end:
            return line.decode("utf-8", "replace").strip().lower()
        self.tell(f"No answer in {self._patience_s / 60:.0f} min: taken for no.")
        return None


class AbsentOperator:
    """Nobody: there is no terminal, so every answer is no."""

    name = "nobody"

    def confirm(self, question: str) -> bool:
        """Say why the answer is no."""
        self.tell(f"{question} Nobody can answer, since this is no terminal: taken for no. Run it in a terminal.")
        return False

    def tell(self, text: str) -> None:
        """Write a line."""
        _write(text)


class SimulatedOperator:
    """Does and confirms everything, as befits a machine that is simulated."""

    name = "simulated operator"

    def __init__(self, interrupts: Interrupts | None = None) -> None:
        self._interrupts = interrupts or Interrupts()

    def confirm(self, question: str) -> bool:
        """Say yes, unless somebody at the keyboard wishes to pause or to stop."""
        return self._interrupts.wanted == "nothing"

    def tell(self, text: str) -> None:
        """Need not be told."""


class RecordedOperator:
    """Another operator, whose answers are written into the run's log."""

    def __init__(self, operator: Operator, view: View) -> None:
        self.log: RunLog | None = None
        """Where answers go, from when on there is a log."""
        self._operator = operator
        self._view = view

    def confirm(self, question: str) -> bool:
        """Ask, and write the answer down.

        Raises:
            RigError: if it cannot be written.
        """
        self._view.clear()
        yes = self._operator.confirm(question)
        if self.log is not None:
            self.log.answer(question, yes=yes, by=getattr(self._operator, "name", "operator"))
        return yes

    def tell(self, text: str) -> None:
        """Pass it on."""
        self._operator.tell(text)


def _write(text: str) -> None:
    with suppress(OSError):  # Ctrl-C also ends whatever a pipe goes to, and must not tear the run
        sys.stderr.write(f"{text}\n")
        sys.stderr.flush()
