"""The stage behind a Grbl controller: moves that are audited, since the wire has no check of its own."""

from itertools import pairwise
from math import inf

from planner.errors import RigError
from planner.program.machine import Stage as StageLimits
from rig.audited_stage import AuditedStage, Move
from rig.devices import Sighting, Watch
from rig.dialects import grbl_lines
from rig.dialects.grbl import Error, Event, Message, Setting, Status, parse_axes
from rig.dialects.grbl_settings import Axes, GrblSettings
from rig.grbl_line import GrblLine
from rig.pace_audit import PaceAudit
from rig.transport import Transport

BOOT_S = 2.0
"""Boards of the Arduino class restart when their port is opened, and say so within this time [s]."""
COMMAND_S = 3.0
SLACK_S = 10.0
SLACK = 1.5
HELD = ("Hold", "Door")
"""States in which it was held up on its way."""
LATE = "check that the axes move freely and that nothing slowed the host down, then home"


class GrblStage(AuditedStage):
    """Stage whose every position is compared with the plan: polled ones with the path, the last to half a step.

    The work frame of the controller (G54) is the film frame, so that the lines on the wire are in its coordinates.
    After anything that goes wrong the stage was stopped, and if its position may be lost it wants to be homed.
    """

    def __init__(
        self,
        transport: Transport,
        *,
        limits: StageLimits,
        controller: GrblSettings,
        origin_mm: Axes,
        pace_tolerance_s: float = inf,
    ) -> None:
        """Talk over a line to the controller with such settings; the film's centre is at a machine position [mm].

        Moves that take longer than by the kinematics by more than `pace_tolerance_s` [s] are a failure; without it that
        is only told by `late_s`.
        """
        reach = tuple((-far, 0.0) for far in controller.travel_mm)
        super().__init__(
            limits=limits,
            step_mm=controller.step_mm,
            origin_mm=origin_mm,
            reach_mm=reach,
            max_speed_mm_s=controller.max_speed_mm_s,
            acceleration_mm_s2=controller.acceleration_mm_s2,
        )
        self._line = GrblLine(transport)
        self._controller = controller
        self.identity = ""
        """What the controller says that it is, once identified."""
        self._pace = PaceAudit(controller)
        self._pace_tolerance_s = pace_tolerance_s

    @property
    def most_in_flight_bytes(self) -> int:
        """The most bytes that ever were sent and not acknowledged."""
        return self._line.most_in_flight_bytes

    @property
    def late_s(self) -> float:
        """By how much the last moves took longer than can be explained: starved, misread or off between reports [s]."""
        return self._pace.late_s

    @property
    def expected_s(self) -> float:
        """Upper bound from the kinematics for all moves since the last `wait_idle` [s]."""
        return self._expected_s

    def identify(self) -> str:
        """Make sure that a Grbl with the expected settings is at the other end, and return its version.

        Raises:
            RigError: if nothing or something else answers, or settings differ.
        """
        self._line.await_banner(BOOT_S)
        said = self._who()
        named = {message.name: message.text for message in said}
        if "VER" not in named or "OPT" not in named:
            raise RigError("What answers on the stage's line is no Grbl: check which port the stage is on.")
        fields = named["OPT"].split(",")
        if len(fields) > 2 and fields[2].isdigit() and int(fields[2]) > 1:
            self._line.limit_bytes = int(fields[2]) - 1
        self._compare_settings(self._line.command(grbl_lines.SETTINGS, COMMAND_S))
        self.identity = named["VER"]
        return self.identity

    def home(self) -> None:
        """Find the reference position, and put the work frame on the film.

        Raises:
            RigError: if homing fails or the stage is not where it ends.
        """
        if not self.identity:
            self.identify()
        if self._line.alarmed or self._line.busy or self._line.status().state not in ("Idle", "Alarm"):
            self.stop()
        self._line.lost = True
        with self._stopped_on_failure():
            self._line.command(grbl_lines.HOME, SLACK * self._homing_s() + SLACK_S)
            self._take_frame()
        self._line.lost = False
        self._at = self._film(self._audit.end_mm)
        self._expected_s = 0.0

    def wait_idle(self, deadline_s: float, watch: Watch | None = None) -> None:
        """Wait until every move is executed and the position is verified [s]; show the way there to `watch`.

        The kinematics set a deadline of their own, half as long again as the moves should take.

        Raises:
            RigError: if that fails, is not done in time, or the stage was seen off its path.
        """
        self._line.queue([grbl_lines.SYNCHRONISE])
        allowed = min(deadline_s, SLACK * self._expected_s + SLACK_S)
        end_s = self._line.now_s() + allowed
        with self._stopped_on_failure():
            while self._line.busy:
                status = self._line.watch(end_s)
                if status is not None:
                    self._look(status, watch)
                if self._line.busy and self._line.now_s() >= end_s:
                    raise RigError(f"The stage was not done within {allowed:.0f} s: {LATE}.")
            self._pace.ended(grbl_lines.SYNCHRONISE_S, self._line.before_s, self._line.heard_s)
            self._verify(self._line.status())
            self._not_late()
        self._expected_s = 0.0

    def position_mm(self) -> tuple[float, float, float]:
        """Return where the post is, as the controller counts its steps [mm]."""
        with self._stopped_on_failure():
            return self._film(_machine(self._line.status()))

    def say_stop(self) -> None:
        """Say that it shall brake, and wait for nothing.

        Raises:
            RigError: if the line is gone.
        """
        self._line.say_hold()

    def stop(self) -> None:
        """Brake along the path, then drop all moves; the position is kept unless an alarm or a restart lost it.

        Raises:
            RigError: if the line is gone, or the controller does not answer.
        """
        speed, acceleration = max(self._controller.max_speed_mm_s), min(self._controller.acceleration_mm_s2)
        self._line.hold(speed / acceleration + 2.0)
        self._line.reset()
        status = self._line.status()
        self._line.lost = self._line.lost or status.state == "Alarm"
        if status.machine_mm is not None:
            self._audit.begin(status.machine_mm)
            self._at = self._film(status.machine_mm)
        self._expected_s = 0.0
        if status.state == "Idle":
            self._line.command(grbl_lines.METRIC_ABSOLUTE, COMMAND_S)

    def close(self) -> None:
        """Give the line back."""
        self._line.close()

    def _go(self, moves: list[Move]) -> None:
        """Queue moves to film positions [mm] at speeds [mm/s], and begin to send them."""
        if self._line.lost:
            raise RigError("The stage does not know where it is: home it.")
        for target, _ in moves:
            self._check_reach(target)
        if self._expected_s == 0:
            path = [self._machine(target) for target in (self._at, *(target for target, _ in moves))]
            self._pace.begin(path, [speed for _, speed in moves], self._line.now_s())
        else:  # it may still be moving
            self._pace.forget()
        for (start, _), (target, speed) in pairwise([(self._at, 0.0), *moves]):
            self._expect(start, target, speed)
            flat, level = start[:2] == target[:2], start[2] == target[2]
            x, y = (None, None) if flat and not level else target[:2]
            self._line.queue(
                [grbl_lines.move_line(speed_mm_s=speed, x_mm=x, y_mm=y, z_mm=None if level else target[2])]
            )
        self._at = moves[-1][0]
        with self._stopped_on_failure():
            self._line.exchange(0.0)

    def _look(self, status: Status, watch: Watch | None) -> None:
        """Compare a report on the way with the path and the time, and show it."""
        at, held = _machine(status), status.state in HELD
        self._audit.on_path(at, (status.feed_mm_min or 0.0) / 60)
        if held:  # late on purpose, and told by the watch
            self._pace.forget()
        self._pace.seen(at, self._line.asked_s, self._line.heard_s)
        self._not_late()
        if watch is not None:
            watch(Sighting(position_mm=self._film(at), held=held))

    def _not_late(self) -> None:
        if self._pace.late_s > self._pace_tolerance_s:
            raise RigError(
                f"The stage is {self._pace.late_s:.2f} s later than planned (allowed are {self._pace_tolerance_s:g}):"
                " it was not fed in time or misread a line; check the cable and the load of this computer, then home."
            )

    def _who(self) -> list[Message]:
        for _ in range(3):
            answer = self._line.ask_identity(COMMAND_S)
            if isinstance(answer, list):
                return answer
            if answer is None:  # deaf after an alarm, or nobody there
                self._line.reset()
            elif answer == Error(number=8):  # still busy with what an earlier run left
                self._line.hold(COMMAND_S)
                self._line.reset()
        raise RigError("What answers on the stage's line does not identify itself: check which port the stage is on.")

    def _compare_settings(self, told: list[Event]) -> None:
        found = {event.number: event.value for event in told if isinstance(event, Setting)}
        wrong = [
            f"${number} is {found.get(number, 'missing')}, expected {value:g}"
            for number, value in self._controller.numbers().items()
            if number not in found or abs(found[number] - value) > 5e-4 * max(1.0, abs(value))
        ]
        if wrong:
            raise RigError(f"The stage's settings are not those of the machine file: {'; '.join(wrong)}: correct one.")

    def _take_frame(self) -> None:
        """Put the work frame on the film, and verify that homing ended where it should."""
        self._line.command(grbl_lines.METRIC_ABSOLUTE, COMMAND_S)
        if not self._on_film():
            self._line.command(grbl_lines.offset_line(*self._origin), COMMAND_S)
            if not self._on_film():
                raise RigError("The stage did not take over the film's origin (G54): check the cable, then home.")
        off = -self._controller.homing_pull_off_mm
        self._audit.begin((off, off, off))
        self._verify(self._line.status())

    def _on_film(self) -> bool:
        told = self._line.command(grbl_lines.OFFSETS, COMMAND_S)
        offsets = {event.name: parse_axes(event.text) for event in told if isinstance(event, Message)}
        wanted = {"G54": self._origin, "G92": (0.0, 0.0, 0.0)}
        return all(
            offset is not None and max(abs(a - b) for a, b in zip(offset, wanted[name], strict=True)) < 1e-3
            for name, offset in ((name, offsets.get(name)) for name in wanted)
        )

    def _verify(self, status: Status) -> None:
        if status.state != "Idle":
            raise RigError(
                f"The stage acknowledged all moves but is in state {status.state}: check the cable, then home."
            )
        self._audit.at_end(_machine(status))

    def _homing_s(self) -> float:
        controller = self._controller
        feed = controller.homing_pull_off_mm / controller.homing_feed_mm_s
        return 1.5 * sum(controller.travel_mm) / controller.homing_seek_mm_s + 10 * feed


def _machine(status: Status) -> Axes:
    if status.machine_mm is None:
        raise RigError("The stage reports no machine position: set $10 to 3, then home.")
    return status.machine_mm
