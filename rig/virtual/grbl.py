"""A virtual Grbl 1.1h: what the firmware says and does on the wire, with exact motion on virtual time.

Its behaviour was written from Grbl's documentation and from what genuine firmware was seen to do; notably a reset
within half a second after an alarm is swallowed, a line that an alarm interrupts is acknowledged before the banner,
and bytes that do not fit into the receive buffer are lost without a word. Left out: arcs, probing, overrides, spindle
speed, stored start-up lines, the time to parse a line and the time of the bytes on the wire.
"""

from collections.abc import Generator
from math import inf
from typing import Literal

from rig.dialects.grbl_settings import Axes, GrblSettings
from rig.virtual.grbl_gcode import LINE_CHARACTERS, ZERO, Block, Frame, GcodeError, Modes, parse_block, strip_line
from rig.virtual.grbl_motion import MotionQueue, Steps
from rig.virtual.grbl_receiver import Receiver
from rig.virtual.grbl_reports import (
    BANNER,
    LOCK,
    build_report,
    modes_report,
    offset_field,
    offsets_report,
    settings_report,
    status_report,
)

ALARM_SILENCE_S = 0.5
REPORTS_PER_OFFSET = 10

State = Literal["Idle", "Run", "Hold", "Jog", "Home", "Alarm", "Door"]
Wait = Literal["room", "empty", "stopped", "reset"] | float
"""What a line waits for: room in the queue, its end, the end of braking, a reset, or a time [s]."""
Mishap = Literal["hard limit", "brown-out"]


class VirtualGrbl:
    """Controller of a three-axis stage, at first locked until it is homed.

    `motion.trace` has the executed path and `offset_steps` by how much the controller is wrong about where it is.
    """

    def __init__(
        self,
        settings: GrblSettings,
        *,
        rx_bytes: int = 128,
        planner_moves: int = 15,
        start_mm: Axes = (-40.0, -30.0, -20.0),
        homing_alarm: int | None = None,
    ) -> None:
        """Switch on with the axes at a machine position [mm] that the controller does not know.

        With a `homing_alarm` (8, 9) every homing fails with it.
        """
        self.settings = settings
        self.numbers = settings.numbers()
        """Settings as `$$` shows them; writing one changes what is shown, not the motion."""
        self.motion = MotionQueue(settings, planner_moves)
        self.homing_alarm = homing_alarm
        self.offset_steps: Steps = self._steps(start_mm)
        """True position less the one the controller believes in [steps]."""
        self._systems: list[Axes] = [ZERO] * 6
        self._out = bytearray()
        self._receiver = Receiver(rx_bytes)
        self._now = 0.0
        self._mishaps: list[tuple[float, Mishap]] = []
        self._restart()
        self.state: State = "Alarm"
        self._say(BANNER + LOCK)

    # --- the wire

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that arrive at a time [s]."""
        self._advance(now_s)
        for byte in data:
            if byte in b"?!~\x18" or byte >= 0x80:
                self._work()
                self._real_time(byte)
                continue
            if not self._receiver.free:
                self._work()
            self._receiver.put(byte)
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

    # --- what tests and a simulated film look at

    @property
    def lost_bytes(self) -> int:
        """Number of bytes that found the receive buffer full."""
        return self._receiver.lost_bytes

    def true_steps(self) -> Steps:
        """Return where the axes really are in machine positions, at the last time told [steps]."""
        x, y, z = (a + b for a, b in zip(self.motion.position_steps(), self.offset_steps, strict=True))
        return (x, y, z)

    def true_mm(self) -> Axes:
        """Return where the axes really are in machine positions, at the last time told [mm]."""
        return self._mm(self.true_steps())

    def schedule(self, mishap: Mishap, at_s: float) -> None:
        """Let something happen at a time [s]: a limit switch trips, or the supply breaks down for a moment."""
        self._mishaps.append((at_s, mishap))
        self._mishaps.sort()

    # --- time

    def _next_s(self) -> float:
        mishap = self._mishaps[0][0] if self._mishaps else inf
        if isinstance(self._wait, float) and not self._held:
            return min(mishap, self._wait)
        if self._wait in ("room", "empty", "stopped"):
            return min(mishap, self.motion.next_s())
        return mishap

    def _advance(self, now_s: float) -> None:
        while (event := self._next_s()) <= now_s:
            self._pass_time(max(event, self._now))
            if self._mishaps and self._mishaps[0][0] <= event:
                self._suffer(self._mishaps.pop(0)[1])
            self._work()
        self._pass_time(max(now_s, self._now))

    def _pass_time(self, now_s: float) -> None:
        self.motion.advance(now_s)
        self._now = now_s
        if self.state in ("Run", "Jog") and not self.motion.moves:
            self.state = "Idle"
        if self._cancelling and self.motion.state == "still":
            self.motion.halt()
            self._cancelling, self.state = False, "Idle"

    # --- the main program: one line after the other, each a generator that yields what it waits for

    @property
    def _held(self) -> bool:
        return self.state in ("Hold", "Door") and self._wait != "stopped"

    def _work(self) -> None:
        while not self._held:
            if self._program is None:
                line = self._receiver.take_line()
                if line is None:
                    break
                self._program, self._line_open = self._run(line), True
            elif not self._ready():
                break
            try:
                self._wait = next(self._program)
            except StopIteration as end:
                self._program, self._wait, self._line_open = None, None, False
                if end.value is not None:
                    self._say(f"error:{end.value}\r\n" if end.value else "ok\r\n")
        if self.state == "Idle" and self.motion.moves:
            self.state = "Run"
            self.motion.start()

    def _ready(self) -> bool:
        match self._wait:
            case "room":
                return not self.motion.full
            case "empty":
                return not self.motion.moves
            case "stopped":
                return self.motion.state == "still"
            case "reset":
                return False
            case None:
                return True
            case time_s:
                return self._now >= time_s

    def _run(self, raw: bytes) -> Generator[Wait, None, int | None]:
        text = strip_line(raw)
        if len(text) > LINE_CHARACTERS:
            return 11
        if not text:
            return 0
        if text[0] == "$":
            return (yield from self._system(text))
        if self.state in ("Alarm", "Jog"):
            return 9
        try:
            block = parse_block(text, self._modes, self._frame())
        except GcodeError as error:
            return error.number
        self._modes = block.modes
        return (yield from self._execute(block))

    def _execute(self, block: Block) -> Generator[Wait, None, int | None]:
        if block.waits:
            yield "empty"
        if block.dwell_s is not None:
            yield self._now + block.dwell_s
        if block.system_offset is not None:
            system, origin = block.system_offset
            self._systems[system] = origin
        if block.shift_mm is not None:
            self._shift = block.shift_mm
        if block.target_mm is not None:
            if not self._within(block.target_mm):
                return (yield from self._soft_limit())
            yield "room"
            feed = inf if block.rapid else block.modes.feed_mm_min / 60
            self._queue(block.target_mm, feed)
        if block.pauses:
            self.state = "Hold"
        if block.ends:
            self._modes = Modes(feed_mm_min=self._modes.feed_mm_min)
            self._say("[MSG:Pgm End]\r\n")
        return 0

    def _queue(self, target: Axes, feed_mm_s: float) -> None:
        self.motion.add(target, feed_mm_s)
        self._target = target

    def _soft_limit(self) -> Generator[Wait, None, int | None]:
        if self.state == "Run":
            self.state = "Hold"
            self.motion.brake()
            yield "stopped"
        self.motion.halt()
        return (yield from self._alarm(2))

    def _alarm(self, number: int) -> Generator[Wait, None, int | None]:
        """Announce an alarm that only a reset ends, deaf for as long as the message takes; ends with a stray ok."""
        self._critical, self.state = True, "Alarm"
        self._say(f"ALARM:{number}\r\n")
        self._deaf = True
        yield self._now + ALARM_SILENCE_S
        self._deaf = False
        self._say("[MSG:Reset to continue]\r\n")
        yield "reset"
        return 0

    def _system(self, text: str) -> Generator[Wait, None, int | None]:
        if text.startswith("$J="):
            return (yield from self._jog(text[3:]))
        if text == "$G":
            self._say(modes_report(self._modes))
        elif text == "$X":
            if self.state == "Alarm":
                self.state = "Idle"
                self._say("[MSG:Caution: Unlocked]\r\n")
        elif self.state not in ("Idle", "Alarm"):
            return 8
        elif text == "$H":
            return (yield from self._home())
        elif text == "$$":
            self._say(settings_report(self.numbers))
        elif text == "$I":
            self._say(build_report(self.motion.capacity, self._receiver.size))
        elif text == "$#":
            self._say(offsets_report(self._systems, self._shift))
        else:
            return self._store(text)
        return 0

    def _store(self, text: str) -> int:
        name, _, value = text[1:].partition("=")
        try:
            number, amount = int(name), float(value)
        except ValueError:
            return 3
        if number not in self.numbers:
            return 3
        if amount < 0:
            return 4
        self.numbers[number] = amount
        return 0

    def _jog(self, text: str) -> Generator[Wait, None, int | None]:
        if self.state not in ("Idle", "Jog"):
            return 8 if self.state != "Alarm" else 9
        try:
            block = parse_block(text, self._modes, self._frame(), jog=True)
        except GcodeError as error:
            return error.number
        if block.target_mm is None:
            return 16
        if not self._within(block.target_mm):
            return 15
        yield "room"
        self._queue(block.target_mm, block.modes.feed_mm_min / 60)
        if self.state == "Idle" and self.motion.moves:
            self.state = "Jog"
            self.motion.start()
        return 0

    def _home(self) -> Generator[Wait, None, int | None]:
        if not self.numbers[22]:
            return 5
        settings, true = self.settings, self.true_mm()
        self.state = "Home"
        near = 2 * settings.homing_pull_off_mm / settings.homing_feed_mm_s
        far = (abs(true[2]) + max(abs(true[0]), abs(true[1]))) / settings.homing_seek_mm_s
        yield self._now + far + 2 * near  # the post first, then both other axes
        if self.homing_alarm is not None:
            self._say(f"ALARM:{self.homing_alarm}\r\nok\r\n")
            self._restart()
            self.state = "Alarm"
            self._say(BANNER + LOCK)
            return None
        off = -settings.homing_pull_off_mm
        corner = self._steps((off, off, off))
        self.motion.trace.append((self._now, corner))
        self.motion.place(corner)
        self._target = self._mm(corner)
        self.offset_steps = (0, 0, 0)
        self.state = "Idle"
        return 0

    # --- real-time commands and mishaps

    def _real_time(self, byte: int) -> None:
        if byte == 0x18:
            self._reset()
        elif self._critical or self.state == "Home":
            return
        elif byte == ord("?"):
            self._say(self._status_report())
        elif byte == ord("~"):
            if self.state in ("Hold", "Door") and self.motion.state == "still":
                self.state = "Idle"
        elif byte in (ord("!"), 0x84, 0x85) and self.state == "Jog":
            self.motion.brake()
            self._cancelling = True
        elif byte in (ord("!"), 0x84) and self.state in ("Idle", "Run", "Hold"):
            self.state = "Hold" if byte == ord("!") else "Door"
            self.motion.brake()

    def _reset(self) -> None:
        if self._deaf:
            return
        lost = 6 if self.state == "Home" else 3 if self.motion.state != "still" else None
        if lost is not None:
            self._lose_position()
            self._say(f"ALARM:{lost}\r\n")
            self.state = "Alarm"
        if self._line_open:  # its acknowledgement comes late, and before the banner
            self._say("ok\r\n")
        self._restart()
        self.state = "Alarm" if self.state == "Alarm" else "Idle"
        self._say(BANNER + (LOCK if self.state == "Alarm" else ""))

    def _suffer(self, mishap: Mishap) -> None:
        if mishap == "brown-out":
            self._lose_position()
            self.offset_steps = self.true_steps()
            self._restart()
            self.motion.place((0, 0, 0))
            self._target = ZERO
            self._out.clear()
            self.state = "Alarm"
            self._say(BANNER + LOCK)
        elif not self._critical:
            self._lose_position()
            self._program = self._alarm(1)
            self._wait = next(self._program)

    def _lose_position(self) -> None:
        """Stop dead: inertia takes the axes further than the controller knows."""
        slip = self._steps(self.motion.halt())
        x, y, z = (a + b for a, b in zip(self.offset_steps, slip, strict=True))
        self.offset_steps = (x, y, z)

    def _restart(self) -> None:
        """Forget everything but the settings and where the axes are."""
        self.motion.halt()
        self._receiver.clear()
        self._program: Generator[Wait, None, int | None] | None = None
        self._wait: Wait | None = None
        self._line_open = self._critical = self._deaf = self._cancelling = False
        self._modes = Modes()
        self._target = self._mm(self.motion.planned)
        self._shift = ZERO
        self._until_offset = 0

    # --- what the controller knows and says

    def _status_report(self) -> str:
        extra, offset = "", self._offset_mm()
        if self._until_offset == 0:
            extra = offset_field(offset)
        elif self._until_offset == REPORTS_PER_OFFSET - 1:
            extra = "|Ov:100,100,100"
        self._until_offset = (self._until_offset or REPORTS_PER_OFFSET) - 1
        state = self.state
        return status_report(
            f"{state}:{int(self.motion.state != 'still')}" if state in ("Hold", "Door") else state,
            self._mm(self.motion.position_steps()),
            offset,
            mask=int(self.numbers[10]),
            free=(self.motion.capacity - len(self.motion.moves), self._receiver.free),
            feed_mm_min=60 * self.motion.speed_mm_s(),
            extra=extra,
        )

    def _frame(self) -> Frame:
        return Frame(position_mm=self._target, systems_mm=tuple(self._systems), shift_mm=self._shift)

    def _offset_mm(self) -> Axes:
        x, y, z = (a + b for a, b in zip(self._systems[self._modes.system], self._shift, strict=True))
        return (x, y, z)

    def _within(self, target: Axes) -> bool:
        travel = self.settings.travel_mm
        return not self.numbers[20] or all(-far <= at <= 0 for at, far in zip(target, travel, strict=True))

    def _steps(self, position: Axes) -> Steps:
        x, y, z = (round(mm * per) for mm, per in zip(position, self.settings.steps_per_mm, strict=True))
        return (x, y, z)

    def _mm(self, steps: Steps) -> Axes:
        x, y, z = (count / per for count, per in zip(steps, self.settings.steps_per_mm, strict=True))
        return (x, y, z)

    def _say(self, text: str) -> None:
        self._out += text.encode("ascii")
