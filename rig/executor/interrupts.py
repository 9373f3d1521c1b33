"""How a person stops a run from the keyboard: the first Ctrl-C at the next safe point, the second at once."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Literal

from planner.errors import RigError


class StoppedError(RigError):
    """The run was stopped in the middle of an operation, as somebody wished."""


class PausedError(RigError):
    """The run ended between two operations, as somebody wished; it can be resumed."""


class Interrupts:
    """What was asked for so far.

    Devices may be waited for only inside `waiting`, where a stop takes effect at once; between, files are written,
    which must not be torn.
    """

    def __init__(self) -> None:
        self.wanted: Literal["nothing", "pause", "stop"] = "nothing"
        self._waiting = False

    def pause(self) -> None:
        """Ask for a pause at the next safe point; asked again, for a stop at once."""
        if self.wanted == "nothing":
            self.wanted = "pause"
        else:
            self.stop()

    def stop(self) -> None:
        """Ask for a stop at once."""
        self.wanted = "stop"
        if self._waiting:
            self._waiting = False
            raise StoppedError("The run was stopped in the middle of an operation: repeat the command with --resume.")

    @contextmanager
    def waiting(self) -> Iterator[None]:
        """Let a stop take effect at any moment of the block.

        Raises:
            StoppedError: if it was asked for.
        """
        self._waiting = True
        try:
            if self.wanted == "stop":
                self.stop()
            yield
        finally:
            self._waiting = False

    @contextmanager
    def from_signals(self) -> Iterator[None]:
        """Take Ctrl-C for a pause and then a stop, and the end of the terminal or of the system for a stop."""

        def heard(number: int, _: FrameType | None) -> None:
            if number == signal.SIGINT:
                self.pause()
            else:
                self.stop()

        numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
        before = {number: signal.signal(number, heard) for number in numbers}
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)
