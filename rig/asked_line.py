"""A conversation with a device that answers a question with one line and never speaks first."""

from collections.abc import Callable
from typing import TypeVar

from rig.dialects.lines import LineParser
from rig.transport import Transport

Answer = TypeVar("Answer")
QUIET_S = 0.1
"""Silence [s] after which nothing late is expected."""
LONGEST_NOISE_S = 2.0


class AskedLine:
    """Line to such a device."""

    def __init__(self, transport: Transport) -> None:
        self.clock = transport.clock
        self._transport = transport
        self._parser = LineParser()
        self._unanswered = False

    def say(self, data: bytes) -> None:
        """Send what is not answered.

        Raises:
            RigError: if the line is gone.
        """
        self._transport.write(data)

    def ask(self, data: bytes, understand: Callable[[str], Answer | None], *, timeout_s: float) -> Answer | None:
        """Send a question, and return the first line that is understood, or None if none came in time [s].

        After a question that was not answered in time the line is listened empty first, lest its late answer is taken
        for that to this one.

        Raises:
            RigError: if the line is gone.
        """
        if self._unanswered:
            self._drain()
        self._transport.write(data)
        end_s = self.clock.now_s() + timeout_s
        self._unanswered = True
        while (left_s := end_s - self.clock.now_s()) > 0:
            for line in self._parser.feed(self._transport.read(left_s)):
                if (answer := understand(line)) is not None:
                    self._unanswered = False
                    return answer
        return None

    def close(self) -> None:
        """Give the line back."""
        self._transport.close()

    def _drain(self) -> None:
        end_s = self.clock.now_s() + LONGEST_NOISE_S
        while self.clock.now_s() < end_s and self._transport.read(QUIET_S):
            pass
        self._parser.forget()
