"""The stage behind a Marlin controller: numbered lines, and the same audit of positions as with Grbl.

Marlin checks every line, so that no spoiled one is obeyed; the audit is for what it does with them: it goes to the edge
of its travel instead of refusing, and loses steps when it is stopped.
"""

from collections import deque
from itertools import pairwise
from math import dist
from typing import Final

from planner.errors import RigError
from planner.program.machine import Stage as StageLimits
from rig.audited_stage import AuditedStage, Move
from rig.devices import Sighting, Watch
from rig.dialects.grbl_settings import Axes
from rig.dialects.marlin import Event, Position, StepsPerMm, Text
from rig.dialects.marlin_settings import MarlinSettings
from rig.marlin_line import MarlinLine
from rig.transport import Transport

COMMAND_S: Final = 10.0
ASK_S: Final = 0.5
"""Time between two questions for the position [s]; each takes the turn of a move."""
SLACK: Final = 1.5
SLACK_S: Final = 10.0
TRIES: Final = 3
STOP: Final = "M410"


class MarlinStage(AuditedStage):
    """Stage whose positions are counted in steps by the controller and compared with the plan.

    After a stop or any failure its position is lost, since Marlin stops dead, and it wants to be homed.
    """

    def __init__(
        self, transport: Transport, *, limits: StageLimits, controller: MarlinSettings, origin_mm: Axes
    ) -> None:
        """Talk over a line to the controller with such settings; the film's centre is at a machine position [mm]."""
        reach = tuple((0.0, far) for far in controller.travel_mm)
        super().__init__(
            limits=limits,
            step_mm=controller.step_mm,
            origin_mm=origin_mm,
            reach_mm=reach,
            max_speed_mm_s=controller.max_speed_mm_s,
            acceleration_mm_s2=controller.acceleration_mm_s2,
        )
        self._line = MarlinLine(transport)
        self._controller = controller
        self.identity = ""
        """What the controller says that it is, once identified."""
        self._moves: deque[str] = deque()
        self._lost = True
        self._asked_s = 0.0

    @property
    def late_s(self) -> float | None:
        """Not told, since its planner is not modelled."""
        return None

    @property
    def resends(self) -> int:
        """How many lines were said again so far."""
        return self._line.resends

    def identify(self) -> str:
        """Make sure that a Marlin with the expected steps is at the other end, and return its version.

        Raises:
            RigError: if nothing or something else answers, or the steps differ.
        """
        self._line.start()
        named = [event.text for event in self._command("M115") if isinstance(event, Text)]
        marlin = next((text for text in named if text.startswith("FIRMWARE_NAME:Marlin")), None)
        if marlin is None:
            raise RigError("What answers on the stage's line is no Marlin: check which port the stage is on.")
        told = [event.steps_per_mm for event in self._command("M503") if isinstance(event, StepsPerMm)]
        wanted = self._controller.steps_per_mm
        if not told or any(abs(a - b) > 0.006 for a, b in zip(told[0], wanted, strict=True)):
            found = told[0] if told else "missing"
            raise RigError(f"The stage's steps (M92) are {found}, expected {wanted}: correct one of them.")
        self.identity = marlin.partition(":")[2].partition(" PROTOCOL")[0]
        return self.identity

    def home(self) -> None:
        """Find the reference position.

        Raises:
            RigError: if homing fails or the stage is not where it ends.
        """
        if not self.identity:
            self.identify()
        else:
            self._line.start()
        self._moves.clear()
        self._lost = True
        controller = self._controller
        homing_s = SLACK * sum(controller.travel_mm) / controller.homing_speed_mm_s + SLACK_S
        with self._stopped_on_failure():
            self._line.command("G28", homing_s)
            for command in ("G21", "G90"):
                self._command(command)
            self._audit.begin(controller.home_mm)
            self._audit.at_end(self._position())
        self._at, self._lost, self._expected_s = self._film(controller.home_mm), False, 0.0

    def wait_idle(self, deadline_s: float, watch: Watch | None = None) -> None:
        """Wait until every move is executed and the position is verified [s]; show the way there to `watch`.

        Raises:
            RigError: if that fails, is not done in time, or the stage was seen off its path.
        """
        allowed_s = min(deadline_s, SLACK * self._expected_s + SLACK_S)
        end_s = self._line.now_s() + allowed_s
        with self._stopped_on_failure():
            while self._moves:
                self._line.command(self._moves[0], max(0.0, end_s - self._line.now_s()))
                self._moves.popleft()
                if self._line.now_s() > self._asked_s + ASK_S:
                    self._look(watch)
                    self._asked_s = self._line.now_s()
            while not self._look(watch) and self._line.now_s() < end_s:
                self._line.sleep(ASK_S)
            self._line.command("M400", max(0.0, end_s - self._line.now_s()))
            self._arrive(end_s)
        self._expected_s = 0.0

    def position_mm(self) -> tuple[float, float, float]:
        """Return where the post is, as the controller counts its steps [mm]."""
        with self._stopped_on_failure():
            return self._film(self._position())

    def say_stop(self) -> None:
        """Say that it shall stop dead, and wait for nothing.

        Raises:
            RigError: if the line is gone.
        """
        self._lost = True
        self._line.tell(STOP)

    def stop(self) -> None:
        """Stop dead and drop all moves; the position is lost, so that the stage has to be homed.

        Marlin reads this in turn, after the line that it is at, unless it was built with its emergency parser.

        Raises:
            RigError: if the line is gone, or the controller does not answer.
        """
        self._moves.clear()
        self._lost, self._expected_s = True, 0.0
        self._command(STOP)

    def close(self) -> None:
        """Give the line back."""
        self._line.close()

    def _go(self, moves: list[Move]) -> None:
        if self._lost:
            raise RigError("The stage does not know where it is: home it.")
        for target, _ in moves:
            self._check_reach(target)
        for (start, _), (target, speed) in pairwise([(self._at, 0.0), *moves]):
            self._expect(start, target, speed)
            words = "".join(f" {axis}{mm:.4f}" for axis, mm in zip("XYZ", self._machine(target), strict=True))
            self._moves.append(f"G1{words} F{60 * speed:.2f}")
        self._at = moves[-1][0]
        with self._stopped_on_failure():
            self._line.command(self._moves[0], COMMAND_S)
            self._moves.popleft()

    def _look(self, watch: Watch | None) -> bool:
        """Compare where it is on the way with the path, show it, and return whether it is at the end.

        Nothing tells whether somebody holds it up: that only shows in the time.
        """
        at = self._position()
        self._audit.on_path(at)
        if watch is not None:
            watch(Sighting(position_mm=self._film(at), held=False))
        return dist(at, self._audit.end_mm) <= max(self._step)

    def _arrive(self, end_s: float) -> None:
        """Verify the position; an `ok` too many may have ended the waiting early."""
        while True:
            position = self._position()
            try:
                self._audit.at_end(position)
            except RigError:
                if self._line.now_s() >= end_s or self._position() == position:
                    raise
            else:
                return

    def _position(self) -> Axes:
        for _ in range(TRIES):
            found = [event.steps for event in self._command("M114") if isinstance(event, Position)]
            if found:
                x, y, z = (n / per for n, per in zip(found[-1], self._controller.steps_per_mm, strict=True))
                return (x, y, z)
        raise RigError("The stage does not tell its position (M114): check the cable, then home.")

    def _command(self, command: str) -> list[Event]:
        return self._line.command(command, COMMAND_S)
