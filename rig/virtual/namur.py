"""A virtual IKA hot plate on a wire: NAMUR commands and its watchdog around a virtual heater.

Source: IKA operating instructions, "Interfaces and outputs". A plate says nothing to what it does not know.
"""

import re
from math import inf
from typing import Final

from rig.virtual.answering import ANSWER_S, LineInbox, Outbox
from rig.virtual.heater import VirtualHeater

_COMMAND: Final = re.compile(r"([A-Z][A-Z0-9_]*)(?:([ @]) *(\d+(?:\.\d+)?))?", re.ASCII)


class VirtualNamurPlate:
    """Such a plate, switched on and cold. Public attributes are settings, the truth and faults, open to tests."""

    def __init__(self, heater: VirtualHeater | None = None, *, safety_c: float = 250.0) -> None:
        self.heater = VirtualHeater() if heater is None else heater
        self.safety_c = safety_c
        """Temperature of the safety circuit, set on the plate itself; targets go up to it [C]."""
        self.heats = False
        self.target_c = 0.0
        self.error_2 = False
        """Whether the watchdog has ended the heating, which it shows as Er 2."""
        self.forgets_target_at_start = False
        """Trait of some models: `START_1` sets the target to 0."""
        self.deaf = False
        """Fault: it neither hears nor answers."""
        self.log: list[str] = []
        """Commands heard."""
        self._inbox = LineInbox()
        self._outbox = Outbox()
        self._trips_s = inf

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that arrive at a time [s]."""
        self._watch(now_s)
        if self.deaf:
            return
        for line in self._inbox.take(data):
            self.log.append(line)
            if (answer := self._answer(line, now_s)) is not None:
                self._outbox.put(f"{answer} \r\n".encode("ascii"), now_s + ANSWER_S)

    def send(self, now_s: float) -> bytes:
        """Return the bytes sent up to a time [s], each once."""
        self._watch(now_s)
        return self._outbox.due(now_s)

    def next_event_s(self, now_s: float) -> float:
        """Return the next time [s] at which the plate does or sends something by itself; infinite if never."""
        self._watch(now_s)
        return min(self._outbox.next_s(), self._trips_s)

    def _watch(self, now_s: float) -> None:
        if now_s > self._trips_s:
            self._heat(on=False, now_s=self._trips_s)
            self.error_2, self._trips_s = True, inf

    def _heat(self, *, on: bool, now_s: float) -> None:
        self.heats = on and not self.error_2
        self.heater.regulate(min(self.target_c, self.safety_c) if self.heats else None, now_s)

    def _answer(self, line: str, now_s: float) -> str | None:
        match = _COMMAND.fullmatch(line)
        if match is None:
            return None
        name, separator, text = match.groups()
        number = None if text is None else float(text)
        if separator == "@" and text is not None:
            return self._watchdog(name, text, now_s)
        match name, number:
            case "IN_NAME", None:
                return "C-MAG HS7"
            case "IN_PV_1" | "IN_PV_2", None:
                return f"{self.heater.measured_c(now_s):.1f} {name[-1]}"
            case "IN_SP_1", None:
                return f"{self.target_c:.1f} 1"
            case "IN_SP_3", None:
                return f"{self.safety_c:.1f} 3"
            case "OUT_SP_1", float(asked_c):
                self.target_c = min(asked_c, self.safety_c)
                self._heat(on=self.heats, now_s=now_s)
            case "START_1", None:
                self.target_c = 0.0 if self.forgets_target_at_start and not self.heats else self.target_c
                self._heat(on=True, now_s=now_s)
            case "STOP_1" | "RESET", None:
                self._heat(on=False, now_s=now_s)
        return None

    def _watchdog(self, name: str, text: str, now_s: float) -> str | None:
        number = float(text)
        if name == "OUT_WD2" and number == 0:
            self._trips_s = inf
        elif name == "OUT_WD1" and 20 <= number <= 1500:
            self._trips_s = now_s + number
        else:
            return None
        return text
