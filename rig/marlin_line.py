"""A conversation with Marlin: one numbered line in flight, sent again for as long as it does not arrive whole.

The numbers make it safe to say a line twice: Marlin takes each number once, in order, and asks for the one it misses.
So an `ok` that got lost, came twice or came early does no harm: the next line shows what Marlin has.
"""

from collections import deque
from typing import Final

from planner.errors import RigError
from rig.dialects.lines import LineParser
from rig.dialects.marlin import ANSWER_BYTES, Busy, Event, Failure, Ok, Resend, Started, encode, understand
from rig.transport import Transport

SILENCE_S: Final = 5.0
"""Silence [s] after which a line is said again; Marlin says every 2 s that it is busy."""
QUIET_S: Final = 0.2
"""Time for the `ok` that usually follows a `Resend` [s]."""
RESENDS: Final = 8
"""How often in a row a line is said again."""
REMEMBERED: Final = 50
"""Lines that can be asked for again."""


class MarlinLine:
    """The line to one controller."""

    def __init__(self, transport: Transport) -> None:
        self.resends = 0
        """How many lines were said again so far."""
        self._transport = transport
        self._parser = LineParser(longest=ANSWER_BYTES)
        self._sent: deque[tuple[int, bytes]] = deque(maxlen=REMEMBERED)
        self._number = 0
        self._waiting: deque[Event] = deque()

    def now_s(self) -> float:
        """Return the time of the line's clock [s]."""
        return self._transport.clock.now_s()

    def sleep(self, duration_s: float) -> None:
        """Let time pass [s]."""
        self._transport.clock.sleep(duration_s)

    def start(self) -> None:
        """Begin to count lines, after what an opened port or a reset may have set off.

        Raises:
            RigError: if it does not answer.
        """
        while self._hear(QUIET_S):
            pass
        self._waiting.clear()
        self._sent.clear()
        self._number = -1
        self.command("M110 N0", SILENCE_S)

    def command(self, command: str, deadline_s: float) -> list[Event]:
        """Say a line, wait until it is queued [s], and return what was told meanwhile.

        Raises:
            RigError: if the line is gone, it is not taken in time, Marlin started anew or failed.
        """
        self._number += 1
        self._sent.append((self._number, encode(command, self._number)))
        self._transport.write(self._sent[-1][1])
        told: list[Event] = []
        end_s, silent_s, again = self.now_s() + deadline_s, self.now_s() + SILENCE_S, 0
        while (now_s := self.now_s()) < end_s:
            event = self._next(min(end_s, silent_s) - now_s)
            if event is None and self.now_s() < silent_s:
                continue
            silent_s = self.now_s() + SILENCE_S
            match event:
                case Ok():
                    return told
                case Resend() | None:
                    if event is not None and event.number == self._number + 1:
                        self._swallow_ok()
                        return told
                    again += 1
                    if again > RESENDS:
                        raise RigError(
                            f"The stage did not take {command!r} after {RESENDS} repetitions: check the cable for"
                            " noise, then home."
                        )
                    self._say_again(self._number if event is None else event.number)
                case Started():
                    raise RigError(
                        "The stage started anew by itself, its position is lost: check its supply, then home."
                    )
                case Failure() if "Last Line" not in event.text:
                    raise RigError(
                        f"The stage failed ({event.text[:60]}): find out why, switch it off and on, then home."
                    )
                case Busy() | Failure():
                    pass
                case _:
                    told.append(event)
        raise RigError(
            f"The stage did not take {command!r} within {deadline_s:g} s: check it and the cable, then home."
        )

    def tell(self, command: str) -> None:
        """Say a line without a number, and wait for nothing.

        Raises:
            RigError: if the line is gone.
        """
        self._transport.write(command.encode("ascii") + b"\n")

    def close(self) -> None:
        """Give the line back."""
        self._transport.close()

    def _say_again(self, number: int) -> None:
        self._swallow_ok()
        known = [line for sent, line in self._sent if sent >= number]
        if not known or number < self._sent[0][0]:
            raise RigError(
                f"The stage asks for line {number}, which was sent too long ago or not at all; the last one is"
                f" {self._number}: it lost count, so home."
            )
        self.resends += len(known)
        self._transport.write(b"\n")  # ends what may be left of a line whose end got lost
        for line in known:
            self._transport.write(line)
            if line is not known[-1]:  # their acknowledgements, or requests, come to the last one
                self._transport.clock.sleep(QUIET_S)
                self._swallow_ok()

    def _swallow_ok(self) -> None:
        """Pass over the acknowledgement that usually follows a request; anything else waits."""
        heard = list(self._waiting) + self._hear(QUIET_S)
        self._waiting = deque(event for event in heard if not isinstance(event, Ok))

    def _next(self, timeout_s: float) -> Event | None:
        if not self._waiting:
            self._waiting.extend(self._hear(timeout_s))
        return self._waiting.popleft() if self._waiting else None

    def _hear(self, timeout_s: float) -> list[Event]:
        return [understand(line) for line in self._parser.feed(self._transport.read(max(0.0, timeout_s)))]
