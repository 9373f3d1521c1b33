"""What a virtual Grbl knows, and how it says so: the part of it that has no commands yet."""

from collections.abc import Generator
from typing import Literal

from rig.dialects.grbl_settings import Axes, GrblSettings
from rig.virtual.grbl_gcode import ZERO, Frame, Modes
from rig.virtual.grbl_motion import MotionQueue, Steps
from rig.virtual.grbl_receiver import Receiver
from rig.virtual.grbl_reports import BANNER, LOCK, offset_field, status_report

REPORTS_PER_OFFSET = 10

State = Literal["Idle", "Run", "Hold", "Jog", "Home", "Alarm", "Door"]
Wait = Literal["room", "empty", "stopped", "reset"] | float
"""What a line waits for: room in the queue, its end, the end of braking, a reset, or a time [s]."""
Mishap = Literal["hard limit", "soft limit", "brown-out"]


class GrblState:
    """Settings, position, modes and lines in work of a controller of a three-axis stage."""

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

    # --- changes

    def _queue(self, target: Axes, feed_mm_s: float) -> None:
        self.motion.add(target, feed_mm_s)
        self._target = target

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
