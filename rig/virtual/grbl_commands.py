"""The commands of a virtual Grbl that begin with `$`: settings, reports, unlocking, jogging, homing."""

from collections.abc import Generator

from rig.virtual.grbl_gcode import GcodeError, parse_block
from rig.virtual.grbl_reports import BANNER, LOCK, build_report, modes_report, offsets_report, settings_report
from rig.virtual.grbl_state import GrblState, Wait


class GrblCommands(GrblState):
    """Controller that knows these commands; each yields what it waits for, and returns the number of its error or 0."""

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
