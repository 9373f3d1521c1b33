"""A balance on a serial line that speaks MT-SICS, as those of Mettler-Toledo do."""

from typing import Final

from planner.errors import RigError
from rig.asked_line import AskedLine
from rig.dialects import sics
from rig.dialects.sics import Outcome, Reply
from rig.transport import Transport

REPLY_S: Final = 1.0
REST_S: Final = 40.0
"""Longest wait for the pan to rest [s]; the balance gives up sooner by itself and says so."""
TRIES: Final = 3
AGREE_G: Final = 0.005
"""How far two weights of the same load may differ [g]."""

_REASONS: Final = {
    Outcome.NOT_NOW: "does not come to rest; keep off drafts and shaking",
    Outcome.MOVING: "does not come to rest; keep off drafts and shaking",
    Outcome.WRONG_PARAMETER: "does not take the command; check its model",
    Outcome.OVERLOAD: "is overloaded; take something off the pan",
    Outcome.UNDERLOAD: "is below its range; put the pan on",
    Outcome.ERROR: "does not understand the command; check its model",
}


class SicsBalance:
    """Such a balance; a `Balance`. The port is first used by the first verb."""

    def __init__(self, transport: Transport) -> None:
        self.identity = ""
        """Serial number of the balance, once connected."""
        self._line = AskedLine(transport)

    def connect(self) -> None:
        """Make sure that a balance answers; does nothing if that is done.

        Raises:
            RigError: if none does.
        """
        for _ in range(0 if self.identity else TRIES):
            reply = self._ask(sics.SERIAL_NUMBER, "I4", REPLY_S)
            if reply is not None and reply.serial_number is not None:
                self.identity = reply.serial_number
                break
        if not self.identity:
            raise RigError("balance: no MT-SICS balance answers; check power, port, and 9600 baud 8N1")

    def zero(self) -> None:
        """Take what lies on the pan for nothing, once that rests.

        Raises:
            RigError: if it does not rest, is too heavy for that, or the balance does not answer.
        """
        self.connect()
        self._at_rest(sics.ZERO, "Z", Outcome.DONE)

    def load_g(self) -> float:
        """Return the weight on the pan, once that rests [g].

        Nothing guards the line against a digit that gets lost, so that two answers in a row have to agree.

        Raises:
            RigError: if it does not rest, is out of range, or the balance does not answer.
        """
        self.connect()
        before_g = self._weight_g()
        for _ in range(TRIES):
            weight_g = self._weight_g()
            if abs(weight_g - before_g) <= AGREE_G:
                return weight_g
            before_g = weight_g
        raise RigError("balance: its weights differ each time; check the cable, and that nothing touches the pan")

    def close(self) -> None:
        """Give the line back."""
        self._line.close()

    def _weight_g(self) -> float:
        weight_g = self._at_rest(sics.STABLE, "S", Outcome.STABLE).weight_g
        assert weight_g is not None  # a stable reply has one
        return weight_g

    def _at_rest(self, command: bytes, name: str, wanted: Outcome) -> Reply:
        reason = "does not answer; check power and cable"
        for _ in range(TRIES):
            reply = self._ask(command, name, REST_S)
            if reply is not None and reply.outcome is wanted:
                return reply
            if reply is not None:
                reason = _REASONS[reply.outcome]
        raise RigError(f"balance: at {name} it {reason}")

    def _ask(self, command: bytes, name: str, timeout_s: float) -> Reply | None:
        def wanted(line: str) -> Reply | None:
            reply = sics.understand(line)
            return reply if reply is not None and reply.command in (name, "") else None

        return self._line.ask(command, wanted, timeout_s=timeout_s)
