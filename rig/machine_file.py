"""A rig as a file describes it, together with the machine that the file names."""

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from planner.errors import InputError
from planner.program import Machine, load_machine, read_toml
from rig.dialects.grbl_settings import Axes, GrblSettings
from rig.dialects.marlin_settings import MarlinSettings
from rig.heating_watch import HeatingLimits
from rig.machine_checks import balance_problems, line_problems, reach_problems, section_problems, syringe_problems
from rig.machine_sections import Deposition
from rig.pump_load import PumpSetup
from rig.rig_file import PAPER, RigFile

SIMULATED_RIG: Final = Path(__file__).parent / "machines" / "simulated.toml"


@dataclass(frozen=True, kw_only=True)
class RigDescription:
    """A rig's file together with the machine that it names."""

    file: RigFile
    machine: Machine

    @property
    def digest(self) -> str:
        """SHA-256 of the rig and its machine as canonical JSON, without the ports, which may change their names."""
        lines = {name: {"port", "baud"} for name in ("stage", "pump", "hot_plate_line", "balance_line")}
        parts = {
            "rig": self.file.model_dump(mode="json", exclude=lines),
            "machine": self.machine.model_dump(mode="json"),
        }
        text = json.dumps(parts, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
        return "sha256:" + hashlib.sha256(text.encode()).hexdigest()

    def simulation(self) -> "RigDescription":
        """Return the same rig with nothing real in it."""
        file = self.file
        changed: dict[str, Any] = dict.fromkeys(file.attended, "simulated")
        for name in ("stage", "pump", "hot_plate_line", "balance_line"):
            if (line := getattr(file, name)) is not None:
                changed[name] = line.model_copy(update={"transport": "simulated"})
        changed["deposition"] = file.deposition or Deposition(flow_ml_min=1.0)
        return RigDescription(file=file.model_copy(update=changed), machine=self.machine)

    def marlin(self) -> MarlinSettings:
        """Return how a Marlin has to be set."""
        line, speed, acceleration = self.file.stage, self._speed_mm_s(), self._acceleration_mm_s2()
        return MarlinSettings(
            steps_per_mm=line.steps_per_mm,
            max_speed_mm_s=speed,
            acceleration_mm_s2=acceleration,
            travel_mm=line.travel_mm,
            homing_speed_mm_s=line.homing_seek_mm_s,
        )

    def _speed_mm_s(self) -> Axes:
        stage = self.machine.stage
        return (stage.travel_speed_mm_s, stage.travel_speed_mm_s, stage.lift_speed_mm_s)

    def _acceleration_mm_s2(self) -> Axes:
        acceleration = self.machine.stage.acceleration_mm_s2
        return (acceleration, acceleration, acceleration)

    def grbl(self) -> GrblSettings:
        """Return how a Grbl has to be set."""
        line = self.file.stage
        return GrblSettings(
            steps_per_mm=line.steps_per_mm,
            max_speed_mm_s=self._speed_mm_s(),
            acceleration_mm_s2=self._acceleration_mm_s2(),
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
    problems = [*line_problems(file, path), *section_problems(file, path)]
    try:
        machine = load_machine(None if file.machine == PAPER else path.parent / file.machine)
    except InputError as error:
        raise InputError([*problems, *error.problems]) from None
    for compared in (syringe_problems, reach_problems, balance_problems):
        problems += compared(file, machine, path)
    if problems:
        raise InputError(problems)
    return RigDescription(file=file, machine=machine)
