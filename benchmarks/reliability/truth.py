"""What is really so on the simulated machine, compared with what the run believes at the end of each operation."""

from collections.abc import Sequence
from itertools import pairwise
from math import dist

from planner.program import Actuate, Cure, Deposit, Pass, Point, ResetAlignment
from rig.executor.operations import LoadChange, Operation
from rig.executor.view import Moment
from rig.machine_file import RigDescription
from rig.virtual.heater import VirtualHeater
from rig.virtual.machine import VirtualMachine

CLOSE_MM = 0.005
PATH_MM = 0.02
DOSE_ML = 0.012
"""Two doses' tolerance and the pump's step: more is a wrong load."""
TOUCHING_MM = 0.5
INK_ML = 0.02
NEAR_C = 3.0


class Truth:
    """A view that checks each operation that the run takes for done, as soon as the next one begins."""

    def __init__(
        self, machine: VirtualMachine, rig: RigDescription, operations: Sequence[Operation], *, area_mm2: float
    ) -> None:
        self.wrong: list[str] = []
        """What the run believes and is not so."""
        self._machine = machine
        self._origin = rig.file.stage.origin_mm
        self._lift_mm = rig.machine.stage.lift_mm
        self._operations = operations
        self._begun: Operation | None = None
        self._trace_from = 0
        self._given_before = (0.0, 0.0)
        self._area_mm2 = area_mm2

    def begin(self, moment: Moment) -> None:
        """Check the operation before, and remember the new one."""
        if self._begun is not None and self._begun.number < moment.operation.number:
            self.check_done()
        self._begun = moment.operation
        self._trace_from = len(self._machine.grbl.motion.trace)
        self._given_before = self._given()
        for heater in (self._machine.hot_air, self._machine.hot_plate):
            heater.hottest_c = heater.body_c(self._machine.clock.now_s())

    def move(self, moment: Moment) -> None:
        """Nothing is checked on the way."""

    def clear(self) -> None:
        """Nothing is shown."""

    def forget(self) -> None:
        """Check nothing of an operation that the run itself says has failed."""
        self._begun = None

    def check_done(self) -> None:
        """Compare an operation that the run takes for done with the truth."""
        operation, machine = self._begun, self._machine
        if operation is None:
            return
        machine.grbl.next_event_s(machine.clock.now_s())
        machine.pump.next_event_s(machine.clock.now_s())
        x, y, z = (at - zero for at, zero in zip(machine.grbl.true_mm(), self._origin, strict=True))
        if machine.grbl.offset_steps != (0, 0, 0):
            self._say(operation, f"the controller is wrong by {machine.grbl.offset_steps} steps")
        if z < self._lift_mm - CLOSE_MM:
            self._say(operation, f"the post is at {z:.3f} mm")
        if isinstance(operation.step, Pass):
            if dist((x, y), operation.step.points_mm[-1]) > CLOSE_MM:
                self._say(operation, f"the post is over ({x:.3f}, {y:.3f})")
            self._check_marks(operation, operation.step.points_mm)
        else:
            self._check_marks(operation, ())
        on = {
            "extruder": machine.extruder.flows,
            "lamp": machine.lamp.shines,
            "hot air": machine.hot_air.target_c is not None,
            "hot plate": machine.hot_plate.target_c is not None,
        }
        for name in (name for name, is_on in on.items() if is_on):
            self._say(operation, f"the {name} is on")
        self._check_given(operation)
        wanted = load_after(self._operations, operation.number)
        moved_ml = machine.pump.plunger.moved_ml
        if abs(moved_ml - wanted) > DOSE_ML:
            self._say(operation, f"the chamber holds {moved_ml:.3f} mL, not {wanted:g}")

    def _check_given(self, operation: Operation) -> None:
        """Compare light, ink and heat since the operation began with what it asks for; a failed try may add to it."""
        machine, now = self._machine, self._given()
        light_s, ink_ml = now[0] - self._given_before[0], now[1] - self._given_before[1]
        match operation.step:
            case Cure(duration_s=duration_s) if light_s < duration_s - 0.01:
                self._say(operation, f"the layer was cured for {light_s:.2f} s, not {duration_s:g}")
            case Deposit(thickness_mm=thickness_mm) if abs(ink_ml - self._area_mm2 * thickness_mm * 1e-3) > INK_ML:
                self._say(operation, f"the layer has {ink_ml:.3f} cm3 of ink")
            case ResetAlignment(temperature_c=wanted_c):
                self._check_heat(operation, machine.hot_air, wanted_c)
            case Actuate(temperature_c=wanted_c):
                self._check_heat(operation, machine.hot_plate, wanted_c)

    def _check_heat(self, operation: Operation, heater: VirtualHeater, wanted_c: float) -> None:
        if heater.hottest_c < wanted_c - NEAR_C:
            self._say(operation, f"it was {heater.hottest_c:.0f} C warm, not {wanted_c:g}")

    def _given(self) -> tuple[float, float]:
        return self._machine.lamp.dose_s(), self._machine.extruder.out_ml()

    def _check_marks(self, operation: Operation, path: tuple[Point, ...]) -> None:
        """Compare every move with the post on the film since the operation began with the pass."""
        machine = self._machine
        for _, steps in machine.grbl.motion.trace[self._trace_from :]:
            at = [count / per for count, per in zip(steps, machine.grbl.settings.steps_per_mm, strict=True)]
            x, y, z = (value - zero for value, zero in zip(at, self._origin, strict=True))
            if z > TOUCHING_MM:
                continue
            if not path or min(_distance((x, y), a, b) for a, b in pairwise(path)) > PATH_MM:
                self._say(operation, f"the film was touched at ({x:.3f}, {y:.3f})")

    def _say(self, operation: Operation, what: str) -> None:
        self.wrong.append(f"after {operation.title}: {what}")


def load_after(operations: Sequence[Operation], number: int) -> float:
    """Return the load that the Program has in the chamber after an operation [g]."""
    load_g = 0.0
    for operation in operations[: number + 1]:
        if isinstance(operation.step, LoadChange):
            load_g = operation.step.load_g
        elif isinstance(operation.step, Pass):
            load_g = operation.step.load_g[-1]
    return load_g


def _distance(point: Point, start: Point, end: Point) -> float:
    way = (end[0] - start[0], end[1] - start[1])
    square = way[0] ** 2 + way[1] ** 2
    along = ((point[0] - start[0]) * way[0] + (point[1] - start[1]) * way[1]) / square
    along = min(1.0, max(0.0, along))
    return dist(point, (start[0] + along * way[0], start[1] + along * way[1]))
