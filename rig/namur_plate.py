"""A hot plate on a serial line that speaks NAMUR, as those of IKA do."""

from typing import Final

from planner.errors import RigError
from rig.asked_line import AskedLine
from rig.dialects.namur import encode, value
from rig.transport import Transport

REPLY_S: Final = 1.0
TRIES: Final = 3
SET_C: Final = 0.6
"""How far the target read back may be from the one that was set [C]; plates without decimals round it."""
PLATE: Final = "IN_PV_2"
TARGET: Final = "IN_SP_1"


class NamurThermostat:
    """Heater of such a plate; a `Thermostat`. The port is first used by the first verb.

    Setting and starting are not answered, so that the target is read back; whether it heats only its temperature shows,
    which `HeatedDevice` watches. Heating starts together with the plate's own watchdog (mode 1: heating off), which
    every reading feeds. Reading seldom is a reason for it to turn the heating off; once it has, the plate shows
    Er 2 until it is switched off and on. Its external sensor is left unplugged: with it the plate would regulate that.

    Args:
        transport: line to the plate, 9600 baud, 7 data bits, even parity.
        watchdog_s: silence after which the plate stops heating by itself [s], 20 to 1500.
    """

    def __init__(self, transport: Transport, *, watchdog_s: int) -> None:
        self.identity = ""
        """What the plate calls itself, once connected."""
        self._line = AskedLine(transport)
        self._watchdog_s = watchdog_s
        self._fed_s: float | None = None

    def connect(self) -> None:
        """Make sure that a plate answers; does nothing if that is done.

        Raises:
            RigError: if none does.
        """
        if self.identity:
            return
        for _ in range(TRIES):
            # a name is no number, as which an answer to an earlier run could come late
            name = self._line.ask(encode("IN_NAME"), _name, timeout_s=REPLY_S)
            if name is not None and self._ask(PLATE) is not None:
                self.identity = name
                return
        raise RigError("hot plate: no NAMUR hot plate answers; check power, port, and 9600 baud 7E1")

    def regulate(self, temperature_c: float) -> None:
        """Heat towards a temperature [C], with the plate's watchdog running.

        Raises:
            RigError: if the plate does not answer, or does not keep the temperature or the watchdog.
        """
        self.connect()
        self._set(temperature_c)
        self._feed()
        self._line.say(encode("START_1"))
        self._set(temperature_c)  # some models forget it when they start
        self._line.say(encode("START_1"))

    def read_c(self) -> float:
        """Return the temperature of the plate's sensor [C], and feed its watchdog if it heats.

        Raises:
            RigError: if the plate does not answer, or was read too seldom.
        """
        self.connect()
        hungry_s = 0.0 if self._fed_s is None else self._line.clock.now_s() - self._fed_s
        if hungry_s > self._watchdog_s:
            raise RigError(
                f"hot plate: it was not read for {hungry_s:.0f} s, so that its watchdog of {self._watchdog_s} s ended"
                " the heating; if it shows Er 2, switch it off and on"
            )
        if hungry_s > self._watchdog_s / 4:
            self._feed()
        return self._asked(PLATE)

    def switch_off(self) -> None:
        """Stop heating, and make sure that the plate is still there to have heard it.

        Raises:
            RigError: if the plate does not answer.
        """
        for _ in range(TRIES):  # it is not answered, so that a lost one would not be noticed
            self._line.say(encode("STOP_1"))
        self._fed_s = None
        self._asked(PLATE)

    def close(self) -> None:
        """Give the line back; the plate's watchdog ends the heating if that was not done."""
        self._line.close()

    def _set(self, temperature_c: float) -> None:
        found_c = self._asked(TARGET)
        for _ in range(TRIES):
            if abs(found_c - temperature_c) <= SET_C:
                return
            self._line.say(encode(f"OUT_SP_1 {round(temperature_c, 1):g}"))
            found_c = self._asked(TARGET)
        if abs(found_c - temperature_c) > SET_C:
            raise RigError(
                f"hot plate: its target stays {found_c:g} C where {temperature_c:g} C were set; raise its safety"
                " temperature, which limits it"
            )

    def _feed(self) -> None:
        command = f"OUT_WD1@{self._watchdog_s}"
        if self._asked(command) != self._watchdog_s:
            raise RigError(f"hot plate: it does not take a watchdog of {self._watchdog_s} s; check its model")
        self._fed_s = self._line.clock.now_s()

    def _asked(self, command: str) -> float:
        for _ in range(TRIES):
            if (answer := self._ask(command)) is not None:
                return answer
        raise RigError(f"hot plate: it does not answer to {command}; check power and cable")

    def _ask(self, command: str) -> float | None:
        return self._line.ask(encode(command), lambda line: value(line, command), timeout_s=REPLY_S)


def _name(line: str) -> str | None:
    return line if line[:1].isalpha() else None
