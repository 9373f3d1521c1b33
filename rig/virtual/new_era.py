"""A virtual NE-1000 syringe pump on a wire: commands, alarms, watchdog and faults around a virtual plunger.

Source: NE-1000 user manual, chapter 10 (RS-232).
"""

import re
from binascii import crc_hqx
from collections.abc import Callable
from math import inf
from typing import Final

from rig.dialects.new_era import ETX, SAFE_FRAME, SPEED_MM_MIN, STX, Alarm, packet
from rig.virtual.plunger import DIRECTIONS, RATE_ML_MIN, Phase, Plunger

ANSWER_S: Final = 0.01
INTER_BYTE_S: Final = 0.5
"""Silence [s] after which an unfinished packet is dropped."""
BOOT_S: Final = 1.0
LONGEST_LINE: Final = 256

_FLOAT = re.compile(r"(?=[.\d]*\d)(?!(?:\.?\d){5})\d{0,4}\.?\d{0,3}", re.ASCII)
_COMMAND = re.compile(r"(\*?)(\d{0,2})([A-Z]{0,3})(.*)", re.DOTALL | re.ASCII)


class VirtualPump:
    """A pump just switched on. Public attributes are settings, the truth and faults, open to tests at any time."""

    def __init__(self, *, diameter_mm: float = 14.43, address: int = 0, lag_s: float = 0.3) -> None:
        self.plunger = Plunger(diameter_mm=diameter_mm, lag_s=lag_s)
        self.address = address
        self.safe_s = 0
        """Time-out of the safe mode [s]; 0 is the basic mode."""
        self.resumes_after_power_failure = False
        self.alarm: Alarm | None = Alarm.RESET
        self.log: list[str] = []
        """Commands executed, without the address."""
        self.stall_at_ml = inf
        """Fault: the motor stalls once so much was travelled [mL]."""
        self.brown_out_at_ml = inf
        """Fault: the power fails for a moment once so much was travelled [mL]."""
        self.out_of_range_at_ml = inf
        """Fault: the program goes out of its range once so much was travelled [mL]."""
        self.refuses_next: str | None = None
        """Fault: the next command that sets something is refused so, as `?OOR`, and not executed."""
        self.lose_reply_to: str | None = None
        """Fault: the next reply to this command is lost."""
        self._selected = 1
        self._buffer = bytearray()
        self._outbox: list[tuple[float, bytes]] = []
        self._heard_s = 0.0
        self._silent_until_s = 0.0
        self._time_out_s = inf

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that arrive at a time [s]."""
        self._advance(now_s)
        if now_s < self._silent_until_s:
            return
        if now_s - self._heard_s > INTER_BYTE_S and (self.safe_s or self._buffer[:1] == bytes([STX])):
            self._buffer.clear()
        self._heard_s = now_s
        self._buffer += data
        while (command := self._take(now_s)) is not None:
            self._answer(command, now_s)

    def send(self, now_s: float) -> bytes:
        """Return the bytes that the pump has sent up to a time [s], each once."""
        self._advance(now_s)
        due = b"".join(data for time_s, data in self._outbox if time_s <= now_s)
        self._outbox = [entry for entry in self._outbox if entry[0] > now_s]
        return due

    def next_event_s(self, now_s: float) -> float:
        """Return the next time [s] at which the pump does or sends something by itself; infinite if never."""
        self._advance(now_s)
        return min([self._next_event()[0], *(time_s for time_s, _ in self._outbox)])

    def water_ml(self, now_s: float) -> float:
        """Return the water in the chamber at a time [mL], which follows the plunger with a lag."""
        self._advance(now_s)
        return self.plunger.water_ml

    def brown_out(self, now_s: float) -> None:
        """Interrupt the power for a moment: counters, program and wire start anew, settings are kept."""
        self._advance(now_s)
        self._fail_power(now_s)

    # ---- time

    def _advance(self, now_s: float) -> None:
        while True:
            time_s, happen = self._next_event()
            self.plunger.pass_time(min(time_s, now_s))
            if time_s > now_s:
                return
            happen(time_s)

    def _next_event(self) -> tuple[float, Callable[[float], None]]:
        events: list[tuple[float, Callable[[float], None]]] = [(self._time_out_s, self._time_out)]
        if self.plunger.running:
            events += [
                (self.plunger.end_s(), lambda _: self.plunger.end_phase()),
                (self.plunger.travel_s(self.stall_at_ml), self._stall),
                (self.plunger.travel_s(self.out_of_range_at_ml), self._run_out),
                (self.plunger.travel_s(self.brown_out_at_ml), self._fail_power),
            ]
        return min(events, key=lambda event: event[0])

    def _stall(self, now_s: float) -> None:
        self.stall_at_ml = inf
        self._stop_with(Alarm.STALL, now_s)

    def _run_out(self, now_s: float) -> None:
        self.out_of_range_at_ml = inf
        self._stop_with(Alarm.PHASE_OUT_OF_RANGE, now_s)

    def _time_out(self, now_s: float) -> None:
        self._time_out_s = inf
        self._stop_with(Alarm.TIME_OUT, now_s)

    def _fail_power(self, now_s: float) -> None:
        self.brown_out_at_ml = self._time_out_s = inf
        self.plunger.clear_counters()
        self._buffer.clear()
        self._outbox.clear()
        self._silent_until_s = now_s + BOOT_S
        self._stop_with(Alarm.RESET, self._silent_until_s)

    def _stop_with(self, alarm: Alarm, time_s: float) -> None:
        self.plunger.halt()
        self.alarm = alarm
        if self.safe_s:  # Told by itself, which does not acknowledge it.
            self._say(f"A?{alarm}", time_s)

    # ---- wire

    def _take(self, now_s: float) -> str | None:
        """Cut the next command out of what has arrived."""
        while self._buffer:
            if self._buffer[0] == STX:
                if len(self._buffer) < 2 or len(self._buffer) <= self._buffer[1]:
                    return None
                length = self._buffer[1]
                data, check = bytes(self._buffer[2 : length - 2]), bytes(self._buffer[length - 2 : length])
                whole = length >= SAFE_FRAME and self._buffer[length] == ETX
                if whole and crc_hqx(data, 0).to_bytes(2, "big") == check:
                    del self._buffer[: length + 1]
                    return data.decode("latin-1")
                del self._buffer[0]
                if self.safe_s:
                    self._say(f"{self._status()}?COM", now_s)
            elif self.safe_s:
                del self._buffer[0]
            else:
                line, end, rest = self._buffer.partition(b"\r")
                if not end:
                    del self._buffer[:-LONGEST_LINE]
                    return None
                self._buffer = rest
                return "".join(character for character in line.decode("latin-1") if character > " ").upper()
        return None

    def _answer(self, command: str, now_s: float) -> None:
        match = _COMMAND.fullmatch(command)
        assert match is not None  # every part may be empty
        system, address, name, argument = match.groups()
        if not system and int(address or 0) != self.address:
            return
        if self.alarm is not None:
            text, self.alarm = f"A?{self.alarm}", None
        elif argument and self.refuses_next is not None:
            text, self.refuses_next = self._status() + self.refuses_next, None
        else:
            self.log.append(name + argument)
            execute = self._commands.get(name)
            answer = "?" if execute is None else execute(self, argument)
            text = self._status() + answer
        self._time_out_s = now_s + self.safe_s if self.safe_s else inf
        if name == self.lose_reply_to:
            self.lose_reply_to = None
        else:
            self._say(text, now_s)

    def _say(self, text: str, time_s: float) -> None:
        data = f"{self.address:02d}{text}".encode("ascii")
        self._outbox.append((time_s + ANSWER_S, packet(data) if self.safe_s else bytes([STX, *data, ETX])))

    def _status(self) -> str:
        if self.plunger.running:
            return "I" if self.plunger.direction == "INF" else "W"
        return "P" if self.plunger.paused else "S"

    # ---- commands: argument in, answer out

    @property
    def _phase(self) -> Phase:
        return self.plunger.phases[self._selected]

    def _idle(self, _: str) -> str:
        return ""

    def _version(self, _: str) -> str:
        return "NE1000V3.923"

    def _safe_mode(self, argument: str) -> str:
        if not argument:
            return f"{self.safe_s}"
        if not _whole(argument, 0, 255):
            return "?OOR"
        self.safe_s = int(argument)
        return ""

    def _power_failure(self, argument: str) -> str:
        if not argument:
            return f"{self.resumes_after_power_failure:d}"
        self.resumes_after_power_failure = argument == "1"
        return ""

    def _diameter(self, argument: str) -> str:
        if not argument:
            return _shown(self.plunger.diameter_mm)
        if self.plunger.running:
            return "?NA"
        if not _FLOAT.fullmatch(argument) or not 0.1 <= float(argument) <= 50:
            return "?OOR"
        self.plunger.set_diameter(float(argument))
        return ""

    def _phase_number(self, argument: str) -> str:
        if not argument:
            return f"{self._selected:02d}"
        if self.plunger.running:
            return "?NA"
        if not _whole(argument, 1, 41):
            return "?OOR"
        self._selected = int(argument)
        self.plunger.phases.setdefault(self._selected, Phase())
        return ""

    def _function(self, argument: str) -> str:
        if not argument:
            return self._phase.function
        if self.plunger.running:
            return "?NA"
        if argument not in ("RAT", "STP"):
            return "?"
        self._phase.function = argument
        return ""

    def _rate(self, argument: str) -> str:
        if self._phase.function != "RAT":
            return "?NA"
        if not argument:
            return _shown(self._phase.rate) + self._phase.rate_units
        value, units = (argument[:-2], argument[-2:]) if argument[-1].isalpha() else (argument, self._phase.rate_units)
        if self.plunger.running and units != self._phase.rate_units:
            return "?NA"
        if not _FLOAT.fullmatch(value) or units not in RATE_ML_MIN:
            return "?OOR"
        low, high = SPEED_MM_MIN
        if not low <= float(value) * RATE_ML_MIN[units] * 1e3 / self.plunger.area_mm2 <= high:
            return "?OOR"
        self._phase.rate, self._phase.rate_units = float(value), units
        return ""

    def _volume(self, argument: str) -> str:
        if not argument:
            return _shown(self._phase.volume) + self.plunger.units
        if self.plunger.running:
            return "?NA"
        if argument in ("UL", "ML"):
            self.plunger.units = argument
        elif _FLOAT.fullmatch(argument):
            self._phase.volume = float(argument)
        else:
            return "?OOR"
        return ""

    def _direction(self, argument: str) -> str:
        if not argument:
            return self._phase.direction
        if self.plunger.running and self._phase.volume:
            return "?NA"
        if argument not in DIRECTIONS:
            return "?"
        self._phase.direction = argument
        return ""

    def _run(self, _: str) -> str:
        if self.plunger.running or self.plunger.phases[1].function != "RAT":
            return "?NA"
        self.plunger.run()
        return ""

    def _stop(self, _: str) -> str:
        self.plunger.pause()
        return ""

    def _dispensed(self, _: str) -> str:
        infused, withdrawn = (_shown(self.plunger.counted(direction)) for direction in DIRECTIONS)
        return f"I{infused}W{withdrawn}{self.plunger.units}"

    def _clear(self, argument: str) -> str:
        if self.plunger.running:
            return "?NA"
        if argument not in DIRECTIONS:
            return "?"
        self.plunger.clear_counter(argument)
        return ""

    _commands: Final = {
        "": _idle,
        "CLD": _clear,
        "DIA": _diameter,
        "DIR": _direction,
        "DIS": _dispensed,
        "FUN": _function,
        "PF": _power_failure,
        "PHN": _phase_number,
        "RAT": _rate,
        "RUN": _run,
        "SAF": _safe_mode,
        "STP": _stop,
        "VER": _version,
        "VOL": _volume,
    }


def _shown(value: float) -> str:
    """Write a number as the pump does, always with its point; a counter rolls over after 9999."""
    texts = (f"{value % 10_000:#.{decimals}f}" for decimals in (3, 2, 1, 0))
    return next((text for text in texts if len(text) <= 5), "9999.")


def _whole(text: str, low: int, high: int) -> bool:
    return text.isascii() and text.isdigit() and low <= int(text) <= high
