"""The rig as a file: which machine it is, what hangs on which line, what must hold before something is begun."""

import hashlib
import json
from dataclasses import dataclass
from math import pi
from pathlib import Path
from typing import Annotated, Final, Literal, Self

from pydantic import Field, model_validator

from planner.errors import InputError
from planner.program import Machine, load_machine, read_toml
from planner.program.operations import Strict
from rig.dialects.grbl_settings import GrblSettings
from rig.dialects.new_era import SPEED_MM_MIN
from rig.pump_load import PumpSetup

SIMULATED_RIG: Final = Path(__file__).parent / "machines" / "simulated.toml"
PAPER: Final = "paper"

Attended = Literal["simulated", "operator"]
Positive = Annotated[float, Field(gt=0)]


class Line(Strict):
    """How one controller is reached."""

    transport: Literal["simulated", "serial"]
    port: Annotated[str, Field(min_length=1)] | None = None
    """Serial port, best by its identity under /dev/serial/by-id."""
    baud: Annotated[int, Field(gt=0)]

    @model_validator(mode="after")
    def _reachable(self) -> Self:
        if self.transport == "serial" and self.port is None:
            raise ValueError('port is missing, allowed with transport = "serial" is the name of a port')
        return self


class StageLine(Line):
    """The stage's controller."""

    baud: Annotated[int, Field(gt=0)] = 115200
    origin_mm: tuple[float, float, float]
    """Machine position of the film's centre, at the film's surface [mm]."""
    steps_per_mm: tuple[Positive, Positive, Positive] = (400.0, 400.0, 400.0)
    travel_mm: tuple[Positive, Positive, Positive] = (200.0, 200.0, 60.0)
    """Machine positions go from minus this to 0 [mm]."""
    homing_feed_mm_s: Positive = 1.0
    homing_seek_mm_s: Positive = 20.0
    homing_pull_off_mm: Positive = 1.0


class PumpLine(Line):
    """The pump, and the syringe in it."""

    baud: Annotated[int, Field(gt=0)] = 19200
    address: Annotated[int, Field(ge=0, le=99)] = 0
    mode: Literal["safe", "basic"] = "safe"
    watchdog_s: Annotated[int, Field(ge=10, le=255)] = 30
    """Silence after which the pump stops itself, in safe mode [s]."""
    syringe_diameter_mm: Annotated[float, Field(ge=0.1, le=50)]
    tolerance_ml: Annotated[float, Field(ge=0.002)] = 0.005
    """Largest difference between the dose asked for and the dose counted."""
    settle_s: Annotated[float, Field(ge=0)] = 1.0


class Interlocks(Strict):
    """What must hold before something dangerous or spoiling is begun."""

    uv_needs_closed_enclosure: bool = True
    hot_air_needs_lifted_post: bool = True
    load_change_needs_lifted_post: bool = True


class Simulated(Strict):
    """How good the simulated parts of a rig are."""

    pump_lag_s: Positive = 0.3
    """Time in which the water follows the plunger [s]."""
    post_friction_g: Annotated[float, Field(ge=0)] = 0.0
    """Part of the load that the post's guide holds back, unseen by the pump's counters [g]."""
    post_noise_g: Annotated[float, Field(ge=0)] = 0.02
    """Standard deviation of the post's force [g]."""
    seed: Annotated[int, Field(ge=0)] = 0
    pace: Annotated[float, Field(ge=0)] = 0.0
    """How many times as fast as the wall's the simulated time passes; 0 is as fast as it can be computed."""


class RigFile(Strict):
    """A rig, as described in a TOML file."""

    machine: Annotated[str, Field(min_length=1)] = PAPER
    """`paper`, or the path of a machine file, seen from this file."""
    stage: StageLine
    pump: PumpLine
    extruder: Attended
    lamp: Attended
    hot_air: Attended
    hot_plate: Attended
    enclosure: Attended = "operator"
    interlocks: Interlocks = Interlocks()
    simulated: Simulated = Simulated()

    @property
    def attended(self) -> tuple[str, ...]:
        """The devices that an operator works."""
        names = ("extruder", "lamp", "hot_air", "hot_plate", "enclosure")
        return tuple(name for name in names if getattr(self, name) == "operator")

    @property
    def is_simulated(self) -> bool:
        """Whether nothing of it is real, nor asks a person."""
        return self.stage.transport == self.pump.transport == "simulated" and not self.attended


@dataclass(frozen=True, kw_only=True)
class RigDescription:
    """A rig's file together with the machine that it names."""

    file: RigFile
    machine: Machine

    @property
    def digest(self) -> str:
        """SHA-256 of the rig and its machine as canonical JSON, without the ports, which may change their names."""
        lines = {"stage": {"port", "baud"}, "pump": {"port", "baud"}}
        parts = {
            "rig": self.file.model_dump(mode="json", exclude=lines),
            "machine": self.machine.model_dump(mode="json"),
        }
        text = json.dumps(parts, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
        return "sha256:" + hashlib.sha256(text.encode()).hexdigest()

    def simulation(self) -> "RigDescription":
        """Return the same rig with nothing real in it."""
        everything = dict.fromkeys(self.file.attended, "simulated")
        lines = {
            name: line.model_copy(update={"transport": "simulated"})
            for name, line in (("stage", self.file.stage), ("pump", self.file.pump))
        }
        return RigDescription(file=self.file.model_copy(update={**everything, **lines}), machine=self.machine)

    def controller(self) -> GrblSettings:
        """Return how the stage's controller has to be set."""
        line, stage = self.file.stage, self.machine.stage
        return GrblSettings(
            steps_per_mm=line.steps_per_mm,
            max_speed_mm_s=(stage.travel_speed_mm_s, stage.travel_speed_mm_s, stage.lift_speed_mm_s),
            acceleration_mm_s2=(stage.acceleration_mm_s2, stage.acceleration_mm_s2, stage.acceleration_mm_s2),
            travel_mm=line.travel_mm,
            homing_feed_mm_s=line.homing_feed_mm_s,
            homing_seek_mm_s=line.homing_seek_mm_s,
            homing_pull_off_mm=line.homing_pull_off_mm,
        )

    def pump_setup(self) -> PumpSetup:
        """Return what the pump's driver must know."""
        line, pump = self.file.pump, self.machine.pump
        return PumpSetup(
            syringe_diameter_mm=line.syringe_diameter_mm,
            rate_ml_min=pump.rate_ml_min,
            ml_per_g=pump.ml_per_g,
            load_g_max=pump.load_g_max,
            address=line.address,
            watchdog_s=line.watchdog_s if line.mode == "safe" else 0,
            tolerance_ml=line.tolerance_ml,
            settle_s=line.settle_s,
        )


def load_rig(path: str | Path | None = None) -> RigDescription:
    """Read a rig from a TOML file, and the machine that it names; without a path the simulated one.

    Raises:
        InputError: with every problem found in either file, and between them.
    """
    path = SIMULATED_RIG if path is None else Path(path)
    file = read_toml(path, RigFile, "rig")
    problems = list(_line_problems(file, path))
    try:
        machine = load_machine(None if file.machine == PAPER else path.parent / file.machine)
    except InputError as error:
        raise InputError([*problems, *error.problems]) from None
    problems += _syringe_problems(file, machine, path)
    problems += _reach_problems(file, machine, path)
    if problems:
        raise InputError(problems)
    return RigDescription(file=file, machine=machine)


def _line_problems(file: RigFile, path: Path) -> list[str]:
    serial = [line.port for line in (file.stage, file.pump) if line.transport == "serial"]
    if len(serial) == 2 and serial[0] == serial[1]:
        return [f"{path}: pump.port is {serial[1]!r}, which is the stage's port too; give each its own"]
    return []


def _reach_problems(file: RigFile, machine: Machine, path: Path) -> list[str]:
    problems, stage, line = [], machine.stage, file.stage
    reaches = (stage.x_mm, stage.y_mm, (0.0, stage.lift_max_mm))
    for name, reach, origin, travel in zip("xyz", reaches, line.origin_mm, line.travel_mm, strict=True):
        low, high = (origin + at for at in reach)
        if low < -travel or high > 0:
            problems.append(
                f"{path}: stage.origin_mm puts the reach of {name}, {reach[0]:g} to {reach[1]:g} mm by machine "
                f"{machine.name!r}, at {low:g} to {high:g} mm of the controller, allowed is {-travel:g} to 0; change "
                "origin_mm, travel_mm or the machine"
            )
    return problems


def _syringe_problems(file: RigFile, machine: Machine, path: Path) -> list[str]:
    problems = []
    pump, diameter_mm = machine.pump, file.pump.syringe_diameter_mm
    area_mm2 = pi / 4 * diameter_mm**2
    low, high = (speed * area_mm2 * 1e-3 for speed in SPEED_MM_MIN)
    if not low <= pump.rate_ml_min <= high:
        problems.append(
            f"{path}: pump.syringe_diameter_mm is {diameter_mm:g}, with which the pump makes {low:.2g} to {high:.4g} "
            f"mL/min, but machine {machine.name!r} has pump.rate_ml_min = {pump.rate_ml_min:g}; change one of them"
        )
    needed_ml = pump.load_g_max * pump.ml_per_g
    if needed_ml > pump.syringe_ml:
        problems.append(
            f"{path}: machine {machine.name!r} has pump.syringe_ml = {pump.syringe_ml:g}, but its largest load needs "
            f"{needed_ml:g} mL; take a larger syringe or a smaller load_g_max"
        )
    return problems
