"""The rig as a file: which machine it is, what hangs on which line, what must hold before something is begun."""

from dataclasses import dataclass
from math import pi
from pathlib import Path
from typing import Annotated, Final, Literal, Self

from pydantic import Field, model_validator

from planner.errors import InputError
from planner.program import Machine, load_machine, read_toml
from planner.program.operations import Strict
from rig.dialects.namur import WATCHDOG_S
from rig.dialects.new_era import SPEED_MM_MIN
from rig.heating_watch import HeatingLimits
from rig.pump_load import PumpSetup

SIMULATED_RIG: Final = Path(__file__).parent / "machines" / "simulated.toml"
PAPER: Final = "paper"

Attended = Literal["simulated", "operator"]


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
    pace_tolerance_s: Annotated[float, Field(ge=0.02)] | None = None
    """How much longer than by its kinematics a stroke may take [s]; without it that is told and not a failure."""


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


class HotPlateLine(Line):
    """A hot plate that speaks NAMUR."""

    baud: Annotated[int, Field(gt=0)] = 9600
    watchdog_s: Annotated[int, Field(ge=WATCHDOG_S[0], le=WATCHDOG_S[1])] = 60
    """Silence after which the plate stops heating by itself [s]."""


class BalanceLine(Line):
    """A balance that speaks MT-SICS."""

    baud: Annotated[int, Field(gt=0)] = 9600


class Deposition(Strict):
    """The extruder's flow."""

    flow_ml_min: Annotated[float, Field(gt=0, le=100)]
    """Through the open valve, found by weighing what comes out in a minute [mL/min]."""


class Curing(Strict):
    """The lamp's light."""

    warm_up_s: Annotated[float, Field(ge=0, le=1800)] = 0.0
    """Time until it has its full brightness [s]; 0 for diodes."""


class Heating(Strict):
    """What is expected of everything that heats; what does not do so is turned off."""

    rise_c: Annotated[float, Field(gt=0, le=50)] = 5.0
    """Least warming within `within_s`, or half of what is missing if that is less."""
    within_s: Annotated[float, Field(ge=5, le=600)] = 60.0
    tolerance_c: Annotated[float, Field(gt=0, le=20)] = 2.0
    """How near counts as reached."""
    overshoot_c: Annotated[float, Field(gt=0, le=50)] = 15.0
    """How much hotter than told, or once reached colder, is a failure."""


class Interlocks(Strict):
    """What must hold before something dangerous or spoiling is begun."""

    uv_needs_closed_enclosure: bool = True
    hot_air_needs_lifted_post: bool = True
    load_change_needs_lifted_post: bool = True


class RigFile(Strict):
    """A rig, as described in a TOML file."""

    machine: Annotated[str, Field(min_length=1)] = PAPER
    """`paper`, or the path of a machine file, seen from this file."""
    stage: StageLine
    pump: PumpLine
    extruder: Attended
    lamp: Attended
    hot_air: Attended
    hot_plate: Literal["simulated", "operator", "namur"]
    enclosure: Attended = "operator"
    balance: Literal["none", "sics"] = "none"
    deposition: Deposition | None = None
    curing: Curing = Curing()
    heating: Heating = Heating()
    hot_plate_line: HotPlateLine | None = None
    balance_line: BalanceLine | None = None
    interlocks: Interlocks = Interlocks()

    def lines(self) -> dict[str, Line]:
        """Return the lines to controllers by the names of their sections."""
        named = {
            "stage": self.stage,
            "pump": self.pump,
            "hot_plate_line": self.hot_plate_line,
            "balance_line": self.balance_line,
        }
        return {name: line for name, line in named.items() if line is not None}


@dataclass(frozen=True, kw_only=True)
class RigDescription:
    """A rig's file together with the machine that it names."""

    file: RigFile
    machine: Machine

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

    def heating_limits(self) -> HeatingLimits:
        """Return what the watch over heaters expects."""
        return HeatingLimits(**self.file.heating.model_dump())


def load_rig(path: str | Path | None = None) -> RigDescription:
    """Read a rig from a TOML file, and the machine that it names; without a path the simulated one.

    Raises:
        InputError: with every problem found in either file, and between them.
    """
    path = SIMULATED_RIG if path is None else Path(path)
    file = read_toml(path, RigFile, "rig")
    problems = [*_line_problems(file, path), *_section_problems(file, path)]
    try:
        machine = load_machine(None if file.machine == PAPER else path.parent / file.machine)
    except InputError as error:
        raise InputError([*problems, *error.problems]) from None
    problems += _syringe_problems(file, machine, path)
    if problems:
        raise InputError(problems)
    return RigDescription(file=file, machine=machine)


def _line_problems(file: RigFile, path: Path) -> list[str]:
    problems, taken = [], dict[str, str]()
    for name, line in file.lines().items():
        if line.transport != "serial" or line.port is None:
            continue
        if line.port in taken:
            problems.append(
                f"{path}: {name}.port is {line.port!r}, which is the {taken[line.port]}'s port too; give each its own"
            )
        taken.setdefault(line.port, name.removesuffix("_line").replace("_", " "))
    return problems


def _section_problems(file: RigFile, path: Path) -> list[str]:
    """Compare who does what with the sections that this needs."""
    needed = [
        ("extruder", file.extruder == "simulated", "deposition", file.deposition),
        ("hot_plate", file.hot_plate == "namur", "hot_plate_line", file.hot_plate_line),
        ("balance", file.balance == "sics", "balance_line", file.balance_line),
    ]
    problems = []
    for key, wanted, section, found in needed:
        if wanted and found is None:
            problems.append(f"{path}: {key} is {getattr(file, key)!r}, but section [{section}] is missing; add it")
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
