"""What a rig's file says: who does what, what hangs on which line, what must hold before something is begun."""

from typing import Annotated, Final, Literal

from pydantic import Field

from planner.program.operations import Strict
from rig.machine_sections import (
    Attended,
    BalanceLine,
    Curing,
    Deposition,
    Heating,
    HotPlateLine,
    Interlocks,
    Line,
    PumpLine,
    Simulated,
    StageLine,
)

PAPER: Final = "paper"
WIRELESS: Final = ("extruder", "lamp", "hot_air", "hot_plate", "enclosure")
"""Devices that need no line: they are simulated or worked by an operator, the plate at least may be."""


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
    simulated: Simulated = Simulated()

    @property
    def attended(self) -> tuple[str, ...]:
        """The devices that an operator works."""
        return tuple(name for name in WIRELESS if getattr(self, name) == "operator")

    @property
    def has_simulated(self) -> bool:
        """Whether anything of it is simulated."""
        lines = any(line.transport == "simulated" for line in self.lines().values())
        return lines or any(getattr(self, name) == "simulated" for name in WIRELESS)

    @property
    def is_simulated(self) -> bool:
        """Whether nothing of it is real, nor asks a person."""
        return not self.attended and not self.has_serial_lines

    @property
    def has_serial_lines(self) -> bool:
        """Whether anything of it hangs on a real port."""
        return any(line.transport == "serial" for line in self.lines().values())

    def lines(self) -> dict[str, Line]:
        """Return the lines that are in use by the names of what hangs on them."""
        named = {
            "stage": self.stage,
            "pump": self.pump,
            "hot_plate": self.hot_plate_line if self.hot_plate == "namur" else None,
            "balance": self.balance_line if self.balance == "sics" else None,
        }
        return {name: line for name, line in named.items() if line is not None}
