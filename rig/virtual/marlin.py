"""A virtual Marlin 2 on a wire: numbered lines, resends, the keep-alive, and motion as of `MotionQueue`.

Left out: heaters, extruders, arcs, overrides, the time to parse a line. Corners follow the junction deviation, which
Marlin has as an option; by default it limits the jump of each axis' speed ("classic jerk").
"""

import re
from math import inf
from typing import Final

from rig.dialects.grbl_settings import Axes, GrblSettings
from rig.dialects.marlin import LINE_BYTES, checksum
from rig.dialects.marlin_settings import MarlinSettings
from rig.virtual.grbl_motion import MotionQueue, Steps

BUSY_S: Final = 2.0
RX_BYTES: Final = 128
START: Final = "start\necho:Marlin 2.1.2.4\necho: Last Updated: 2024 | Author: (none, default config)\n"

_NUMBERED = re.compile(r"N(-?\d+) ?", re.ASCII)
_WORD = re.compile(r"([A-Z])(-?\d*\.?\d*)", re.ASCII)


class VirtualMarlin:
    """Controller just switched on. Public attributes are the truth, open to tests at any time."""

    def __init__(
        self, settings: MarlinSettings, *, planner_moves: int = 15, start_mm: Axes = (40.0, 30.0, 20.0)
    ) -> None:
        self.settings = settings
        self.motion = MotionQueue(
            GrblSettings(
                steps_per_mm=settings.steps_per_mm,
                max_speed_mm_s=settings.max_speed_mm_s,
                acceleration_mm_s2=settings.acceleration_mm_s2,
                travel_mm=settings.travel_mm,
                junction_deviation_mm=settings.junction_deviation_mm,
            ),
            planner_moves,
        )
        self.homed = False
        self.executed: list[str] = []
        """Commands done, in order."""
        self.lost_bytes = 0
        self._start_mm = start_mm
        self._feed_mm_s = 1.0
        self._target: Axes = (0.0, 0.0, 0.0)
        self._out = bytearray()
        self._now = 0.0
        self._restart()
        self._out += START.encode("ascii")

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that arrive at a time [s]."""
        self._advance(now_s)
        fits = data[: RX_BYTES - len(self._rx)]
        self.lost_bytes += len(data) - len(fits)
        self._rx += fits
        self._work()

    def send(self, now_s: float) -> bytes:
        """Return the bytes sent up to a time [s], each once."""
        self._advance(now_s)
        data = bytes(self._out)
        self._out.clear()
        return data

    def next_event_s(self, now_s: float) -> float:
        """Return the next time [s] at which the controller may say something by itself; infinite if never."""
        self._advance(now_s)
        return now_s if self._out else self._next_s()

    def brown_out(self, now_s: float) -> None:
        """Interrupt the supply for a moment: lines, moves and the position are forgotten."""
        self._advance(now_s)
        self.motion.halt()
        self._restart()
        self.homed = False
        self._out[:] = START.encode("ascii")

    def true_mm(self) -> Axes:
        """Return where the axes are at the last time told, once homed [mm]."""
        x, y, z = (n / per for n, per in zip(self.motion.position_steps(), self.settings.steps_per_mm, strict=True))
        return (x, y, z)

    # --- time

    def _restart(self) -> None:
        self._rx = bytearray()
        self._last = 0
        self._waiting: tuple[str, dict[str, float], float] | None = None
        self._busy_s = inf

    def _next_s(self) -> float:
        until_s = self._waiting[2] if self._waiting is not None else inf
        # a pause that is over waits for the motion
        return min(self._busy_s, until_s if until_s > self._now else inf, self.motion.next_s())

    def _advance(self, now_s: float) -> None:
        while (event_s := self._next_s()) <= now_s:
            self._now = max(self._now, event_s)
            self.motion.advance(self._now)
            if self._now >= self._busy_s:
                self._say("echo:busy: processing")
                self._busy_s = self._now + BUSY_S
            self._work()
        self._now = max(self._now, now_s)
        self.motion.advance(self._now)

    def _work(self) -> None:
        while True:
            if self._waiting is not None:
                name, words, until_s = self._waiting
                if not self._ready(name, until_s):
                    break
                self._waiting, self._busy_s = None, inf
                self._finish(name, words)
            line, end, rest = self._rx.partition(b"\n")
            if not end:
                del self._rx[:-LINE_BYTES]
                break
            self._rx = rest
            self._take(line.decode("latin-1").strip())

    # --- lines

    def _take(self, line: str) -> None:
        body, star, check = line.rpartition("*")
        command = body if star else line
        match = _NUMBERED.match(command)
        if not line:
            return None
        if match is not None:
            command = command[match.end() :]
            if not star:
                return self._again("No Checksum with line number")
            if str(checksum(body.encode("latin-1"))) != check:
                return self._again("checksum mismatch")
            if int(match[1]) != self._last + 1 and not command.startswith("M110"):
                return self._again("Line Number is not Last Line Number+1")
            self._last = int(match[1])
        words = {letter: float(text or 0) for letter, text in _WORD.findall(command) if text not in ("-", ".", "-.")}
        self._begin(command.split(" ")[0], words)
        return None

    def _again(self, reason: str) -> None:
        self._say(f"Error:{reason}, Last Line: {self._last}")
        self._rx.clear()  # what came behind it is flushed
        self._say(f"Resend: {self._last + 1}")
        self._say("ok")

    def _begin(self, name: str, words: dict[str, float]) -> None:
        pause_s = words.get("S", 0.0) + words.get("P", 0.0) / 1000 if name == "G4" else 0.0
        if name == "G28":
            pause_s = sum(self.settings.travel_mm) / self.settings.homing_speed_mm_s
        self._waiting = (name, words, self._now + pause_s)
        self._busy_s = self._now + BUSY_S

    def _ready(self, name: str, until_s: float) -> bool:
        if name in ("G0", "G1"):
            return not self.motion.full
        if name in ("G4", "G28", "M400"):
            return not self.motion.moves and self._now >= until_s
        return True

    def _finish(self, name: str, words: dict[str, float]) -> None:
        self.executed.append(name)
        match name:
            case "G0" | "G1":
                self._move(words)
            case "G28":
                self.homed, self._target = True, self.settings.home_mm
                self.motion.place(self._steps(self._target))
            case "M110":
                self._last = int(words.get("N", self._last))
            case "M114":
                x, y, z = self._target
                a, b, c = self.motion.position_steps()
                self._say(f"X:{x:.2f} Y:{y:.2f} Z:{z:.2f} E:0.00 Count X:{a} Y:{b} Z:{c}")
            case "M115":
                self._say("FIRMWARE_NAME:Marlin 2.1.2.4 PROTOCOL_VERSION:1.0 MACHINE_TYPE:stage EXTRUDER_COUNT:0")
            case "M410":
                self.motion.halt()
                self._target = self.true_mm()
            case "M503":
                x, y, z = self.settings.steps_per_mm
                self._say(f"echo:  M92 X{x:.2f} Y{y:.2f} Z{z:.2f} E500.00")
            case "G21" | "G90" | "G4" | "M400":
                pass
            case _:
                self._say(f'echo:Unknown command: "{name}"')
        self._say("ok")

    def _move(self, words: dict[str, float]) -> None:
        self._feed_mm_s = words["F"] / 60 if "F" in words else self._feed_mm_s
        if not self.homed:
            self._say("echo:Home XYZ First")
            return
        # software endstops: Marlin goes to the edge instead of refusing
        x, y, z = (
            min(max(words.get(name, at), 0.0), far)
            for name, at, far in zip("XYZ", self._target, self.settings.travel_mm, strict=True)
        )
        self._target = (x, y, z)
        self.motion.add(self._target, self._feed_mm_s)
        self.motion.start()

    def _steps(self, position: Axes) -> Steps:
        x, y, z = (round(mm * per) for mm, per in zip(position, self.settings.steps_per_mm, strict=True))
        return (x, y, z)

    def _say(self, text: str) -> None:
        self._out += f"{text}\n".encode("ascii")
