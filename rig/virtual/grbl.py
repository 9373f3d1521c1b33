"""A virtual Grbl 1.1h: what the firmware says and does on the wire, with exact motion on virtual time.

Its behaviour was written from Grbl's documentation and from what genuine firmware was seen to do; notably a reset
within half a second after an alarm is swallowed, a line that an alarm interrupts is acknowledged before the banner,
and bytes that do not fit into the receive buffer are lost without a word. Left out: arcs, probing, overrides, spindle
speed, stored start-up lines, the time to parse a line and the time of the bytes on the wire.
"""

from collections.abc import Generator
from math import inf

from rig.virtual.grbl_commands import GrblCommands
from rig.virtual.grbl_gcode import LINE_CHARACTERS, ZERO, Block, GcodeError, Modes, parse_block, strip_line
from rig.virtual.grbl_reports import BANNER, LOCK
from rig.virtual.grbl_state import Mishap, Wait

ALARM_SILENCE_S = 0.5


class VirtualGrbl(GrblCommands):
    """Controller of a three-axis stage, at first locked until it is homed.

    `motion.trace` has the executed path and `offset_steps` by how much the controller is wrong about where it is.
    """

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

    def schedule(self, mishap: Mishap, at_s: float) -> None:
        """Let something happen at a time [s]: a switch trips, a line asks for too far, or the supply breaks down."""
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
        elif mishap == "soft limit" and not self._critical:
            self._program = self._soft_limit()
            self._wait = next(self._program)
        elif not self._critical:
            self._lose_position()
            self._program = self._alarm(1)
            self._wait = next(self._program)
