"""A conversation with a New Era pump: one command, one answer, however much of it gets lost on the way."""

import logging
from typing import Final

from planner.errors import RigError
from rig.dialects.new_era import Alarm, PumpError, Reply, ReplyParser, encode, packet
from rig.transport import Transport

REPLY_S: Final = 0.6
"""Longest wait for an answer [s]; the pump needs some 10 ms, and after 0.5 s it drops an unfinished packet."""
QUIET_S: Final = 0.1
"""Silence [s] after which nothing late is expected."""
TRIES: Final = 5

_REFUSALS: Final = {
    PumpError.UNKNOWN: "does not know the command; check the pump's model",
    PumpError.NOT_NOW: "says that it cannot do so now; check that nobody works on its keys",
    PumpError.OUT_OF_RANGE: "says that the value is out of range; check the syringe's diameter and the rate",
    PumpError.BAD_PACKET: "gets damaged packets; check the cable",
    PumpError.IGNORED: "ignores the command; check its program",
}
_log = logging.getLogger(__name__)


class PumpLink:
    """The line to one pump, in safe mode with a watchdog [s], or in basic mode with 0."""

    def __init__(self, transport: Transport, *, address: int, watchdog_s: int) -> None:
        self.clock = transport.clock
        self._transport = transport
        self._address = address
        self._watchdog_s = watchdog_s
        self._parser = ReplyParser(safe=watchdog_s > 0)
        self._other_mode = ReplyParser(safe=watchdog_s == 0)
        self._alarms: set[Alarm] = set()

    def open(self) -> str:
        """Set the mode and return what the pump says that it is, as `NE1000V3.923`.

        Raises:
            RigError: if no New Era pump answers at the address.
        """
        heard = 0
        for _ in range(TRIES):
            # As a packet, which either mode takes and answers in the new mode. The returns end what the basic mode
            # may still have in its line, and what it makes of a packet if it does not know them.
            self._transport.write(b"\r" + packet(f"{self._address}SAF{self._watchdog_s}".encode("ascii")) + b"\r")
            heard += self._drain()
            if (version := self._exchange("VER")) is not None and version.answers("VER"):
                return version.data
        what = f"something answers, but no New Era pump with address {self._address}" if heard else "nothing answers"
        raise RigError(f"pump: {what}; check power, port, baud rate and address")

    def ask(self, command: str) -> Reply:
        """Return the answer to a command that may be given twice; it is repeated until it is answered.

        Raises:
            RigError: if it is refused or not answered.
        """
        refusal: PumpError | None = None
        for attempt in range(TRIES):
            if attempt:
                self._drain()
            reply = self._exchange(command)
            if reply is not None and reply.answers(command):
                return reply
            if reply is not None and reply.error is not None:
                refusal = reply.error
            _log.info("pump: %s was answered by %s, attempt %d", command or "status", reply, attempt + 1)
        reason = "does not answer; check power and cable" if refusal is None else _REFUSALS[refusal]
        raise RigError(f"pump: at {command or 'the query of its status'} the pump {reason}")

    def say_once(self, command: str) -> Reply | None:
        """Give a command that must not be repeated, and return its answer, or None if there was none."""
        return self._exchange(command)

    def tell(self, command: str) -> None:
        """Give a command without listening for its answer.

        Raises:
            RigError: if the line is gone.
        """
        self._transport.write(encode(command, address=self._address, safe=self._parser.safe))

    def ensure(self, name: str, argument: str, wanted: str) -> None:
        """Set a value unless the pump already has it, and read it back.

        Args:
            name: the command, which by itself asks for the value.
            argument: what sets the value.
            wanted: the value as the pump tells it, but for zeros and points at its end.

        Raises:
            RigError: if the pump refuses or does not keep it.
        """
        found = ""
        for _ in range(TRIES):
            # Asked twice, since an answer of the basic mode may be damaged, and a new diameter clears the counters.
            if any(_bare(found := self.ask(name).data) == _bare(wanted) for _ in range(2)):
                return
            self.ask(name + argument)
        raise RigError(f"pump: {name} stays {found} where {wanted} was set; check that nobody works on its keys")

    def synchronise(self) -> None:
        """Make sure that whatever was said before is answered or lost.

        The line keeps the order, so that after the answer to a question no older one can come.

        Raises:
            RigError: if the pump does not answer.
        """
        self._drain()
        self.ask("VER")

    def take_alarms(self) -> frozenset[Alarm]:
        """Return the alarms since the last call."""
        alarms = frozenset(self._alarms)
        self._alarms.clear()
        return alarms

    def _exchange(self, command: str) -> Reply | None:
        """Say a command and return the first reply that can be meant for it."""
        self.tell(command)
        end_s = self.clock.now_s() + REPLY_S
        while (left_s := end_s - self.clock.now_s()) > 0:
            for reply in self._hear(left_s)[1]:
                if reply.address != self._address:
                    continue
                if reply.alarm is not None or reply.error is not None or reply.answers(command):
                    return reply
        return None

    def _drain(self) -> int:
        """Let late bytes go by, and return how many there were."""
        end_s = self.clock.now_s() + REPLY_S
        count = 0
        while self.clock.now_s() < end_s and (data := self._hear(QUIET_S)[0]):
            count += len(data)
        self._parser.forget()
        return count

    def _hear(self, timeout_s: float) -> tuple[bytes, list[Reply]]:
        """Read, and note every alarm, which the pump tells only once: in the other mode if it has yet to change it."""
        data = self._transport.read(timeout_s)
        replies = self._parser.feed(data)
        for reply in (*replies, *self._other_mode.feed(data)):
            if reply.alarm is not None and reply.address == self._address:
                self._alarms.add(reply.alarm)
        return data, replies


def _bare(value: str) -> str:
    """Drop what the pump adds to a number: leading zeros, and zeros and the point at its end, before any unit."""
    digits = value.rstrip("UMLH")
    units = value[len(digits) :]
    return (f"{float(digits):g}" if digits.replace(".", "").isdigit() else digits) + units
