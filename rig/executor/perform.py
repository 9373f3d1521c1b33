"""How each kind of operation is done with the devices, and what was measured of it."""

from collections.abc import Callable
from dataclasses import dataclass, field
from statistics import fmean
from typing import Any

from planner.errors import RigError
from planner.program import Actuate, Cure, Cut, Deposit, Machine, Pass, Point, ResetAlignment
from planner.program.as_run import Outcome
from planner.program.timing import move_s, pass_s
from rig.devices import HotAir, HotPlate, Sighting, SwitchedByHand, WarmsUp, Watch
from rig.executor.interlocks import Guard
from rig.executor.interrupts import PausedError
from rig.executor.machine import Devices
from rig.executor.operations import LoadChange, Step
from rig.executor.scale import Scale
from rig.executor.stroke import Stroke

NEVER_S = 86_400.0
"""For waits that end by a limit of their own [s]."""
HOT_S = 1800.0
DEPOSITED_S = 3600.0
LATE_S = 0.1
"""Lateness of a pass that is noted [s]."""
LOOK_S = 1.0
"""Time between two looks at the enclosure while the lamp shines, or at the temperature while it is held [s]."""


@dataclass(kw_only=True)
class Measured:
    """What is known about an operation, filled in while it is done."""

    outcome: Outcome = "done"
    stroke: Pass | None = None
    facts: dict[str, Any] = field(default_factory=dict)
    """Further fields of `AsRunOperation`."""


class Performer:
    """Does one operation after the other, each from a lifted post to a lifted post.

    Args:
        devices: what it is done with.
        guard: interlocks, checked before each.
        machine: limits and speeds.
        outline_mm: region that is covered with ink.
        scale: weighs the load, where there is a balance.
        show: called with where the stage was seen.
        show_temperature: called with what was measured while something heats [C].
        show_time: called now and then while nothing else is to be seen.
    """

    def __init__(
        self,
        devices: Devices,
        guard: Guard,
        machine: Machine,
        outline_mm: tuple[Point, ...],
        *,
        scale: Scale | None,
        show: Watch,
        show_temperature: Callable[[float], None],
        show_time: Callable[[], None],
    ) -> None:
        self._devices = devices
        self._guard = guard
        self._machine = machine
        self._outline = outline_mm
        self._scale = scale
        self._show = show
        self._show_temperature = show_temperature
        self._show_time = show_time

    def perform(self, step: Step, measured: Measured, *, weigh: bool = False) -> None:
        """Do a step, and fill in what was measured, even if it fails on the way; `weigh` a load that was changed.

        Raises:
            RigError: if a device fails, an interlock refuses, or somebody stops it.
        """
        match step:
            case Deposit():
                self._deposit(step, measured)
            case ResetAlignment():
                self._reset(step, measured)
            case LoadChange():
                self.change_load(step.load_g)
                if weigh:
                    measured.facts["weighed_load_g"] = self.weigh()
            case Pass():
                self._scratch(step, measured)
            case Cure():
                self._cure(step)
            case Cut():
                if not self._devices.operator.confirm("Cut the film along the plan's line. Is it cut?"):
                    raise PausedError("The film is not cut yet: cut it, then resume.")
            case Actuate():
                self._actuate(step, measured)
        measured.facts["position_mm"] = self._devices.stage.position_mm()
        measured.facts["load_g"] = self._devices.load.load_g()

    def wait_off(self, step: Step) -> None:
        """Wait until what a step that is done switched on by hand is off again: what follows may be ink, or hands.

        Raises:
            PausedError: if it is not.
        """
        devices = self._devices
        match step:
            case ResetAlignment():
                device = devices.hot_air
            case Cure():
                device = devices.lamp
            case Actuate():
                device = devices.hot_plate
            case _:
                return
        if isinstance(device, SwitchedByHand):
            device.wait_off()

    def change_load(self, load_g: float) -> None:
        """Change the load of the lifted post and wait until the pump's counters show it [g].

        Raises:
            RigError: if the post is not lifted, or the dose fails its audit.
        """
        self._guard.before_load_change()
        self._devices.load.set_load(load_g)
        self._devices.load.wait_settled(NEVER_S)

    def weigh(self) -> float | None:
        """Weigh the load and compare it with the pump's counters; return it [g], or None without a balance.

        Raises:
            RigError: if they differ, after which the load counts as unknown; or a device fails.
        """
        return None if self._scale is None else self._scale.weigh(self._show)

    def lift(self) -> None:
        """Lift the post to its clearance, verified.

        Raises:
            RigError: if it does not get there.
        """
        self._devices.stage.lift()
        self._devices.stage.wait_idle(NEVER_S, self._show)

    def _scratch(self, step: Pass, measured: Measured) -> None:
        devices, stage = self._devices, self._machine.stage
        self._guard.before_pass(step.load_g[0])
        devices.stage.lift()
        devices.stage.move_to(*step.points_mm[0])
        devices.stage.wait_idle(NEVER_S, self._show)
        stroke = Stroke(step, devices.load, devices.gauge)

        def watch(seen: Sighting) -> None:
            stroke(seen)
            self._show(seen)

        begun_s = devices.clock.now_s()
        try:
            devices.stage.scratch(step)
            devices.stage.wait_idle(NEVER_S, watch)
        except RigError:
            measured.stroke = stroke.so_far()
            raise
        took_s = devices.clock.now_s() - begun_s
        devices.load.wait_settled(NEVER_S)
        lowering_s = move_s(stage.lift_mm, stage.lift_speed_mm_s, stage.acceleration_mm_s2)
        measured.stroke, measured.facts["post_load_g"] = stroke.done(took_s - lowering_s, pass_s(step, stage))
        late_s = devices.stage.late_s
        if late_s is not None and late_s > LATE_S:
            measured.facts["note"] = f"{late_s:.2f} s later than planned"
        if stroke.held:
            measured.outcome = "spoiled"
            measured.facts["note"] = "held up on the way"
        self.lift()

    def _deposit(self, step: Deposit, measured: Measured) -> None:
        self.lift()
        extruder = self._devices.extruder
        extruder.deposit(self._outline, step.thickness_mm)
        extruder.wait_deposited(DEPOSITED_S)
        measured.facts["deposited_ml"] = extruder.deposited_ml

    def _reset(self, step: ResetAlignment, measured: Measured) -> None:
        self._guard.before_hot_air()
        air = self._devices.hot_air
        try:
            air.set_temperature(step.temperature_c)
            air.wait_temperature(HOT_S, self._show_temperature)
            self._hold(air, step.duration_s, measured)
        finally:
            air.turn_off()

    def _cure(self, step: Cure) -> None:
        self._guard.before_uv()
        lamp, clock = self._devices.lamp, self._devices.clock
        try:
            lamp.turn_on()
            if isinstance(lamp, WarmsUp):
                lamp.wait_warm(HOT_S, self._guard.during_uv)
            end_s = clock.now_s() + step.duration_s
            while (left_s := end_s - clock.now_s()) > 0:
                clock.sleep(min(LOOK_S, left_s))
                self._guard.during_uv()
                self._show_time()
        finally:
            lamp.turn_off()

    def _actuate(self, step: Actuate, measured: Measured) -> None:
        plate = self._devices.hot_plate
        try:
            plate.set_temperature(step.temperature_c)
            plate.wait_temperature(HOT_S, self._show_temperature)
            self._hold(plate, step.hold_s, measured)
        finally:
            plate.turn_off()

    def _hold(self, heater: HotAir | HotPlate, duration_s: float, measured: Measured) -> None:
        """Let time pass [s] and look at the temperature again and again, which is what its watch and watchdog need."""
        clock, seen_c = self._devices.clock, list[float]()
        end_s = clock.now_s() + duration_s
        while True:
            seen_c.append(heater.temperature_c())
            self._show_temperature(seen_c[-1])
            measured.facts["temperature_c"] = fmean(seen_c)
            if (left_s := end_s - clock.now_s()) <= 0:
                return
            clock.sleep(min(LOOK_S, left_s))
