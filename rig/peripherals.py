"""The devices around stage and pump, as a rig's file describes them; what an operator does is left out."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from rig.extruder import PneumaticExtruder
from rig.heated_device import HeatedDevice, Thermostat
from rig.lamp import SwitchedLamp
from rig.machine_file import RigDescription
from rig.machine_sections import Line
from rig.namur_plate import NamurThermostat
from rig.sics_balance import SicsBalance
from rig.transport import Clock, Framing, Transport
from rig.virtual.device import VirtualDevice
from rig.virtual.enclosure import VirtualEnclosure
from rig.virtual.machine import VirtualMachine
from rig.virtual.thermostat import SimulatedThermostat

Controller = Literal["stage", "pump", "hot_plate", "balance"]
"""What hangs on a line."""
OpenLine = Callable[[Controller, Line, Framing, VirtualDevice], Transport]
"""Opens a line: its name, its description, how its bytes are framed, and what is at its end if it is simulated."""


@dataclass(frozen=True, kw_only=True)
class Peripherals:
    """The devices around stage and pump; None where an operator does it, or none is there."""

    extruder: PneumaticExtruder | None
    lamp: SwitchedLamp | None
    hot_air: HeatedDevice | None
    hot_plate: HeatedDevice | None
    enclosure: VirtualEnclosure | None
    balance: SicsBalance | None
    plate_line: NamurThermostat | None
    """What the hot plate hangs on, if that is a line."""

    def connect(self) -> None:
        """Make sure that what hangs on a line answers; it is not told anything.

        Raises:
            RigError: if something does not.
        """
        for device in (self.plate_line, self.balance):
            if device is not None:
                device.connect()

    def identities(self) -> dict[str, str]:
        """Return what the devices on lines say that they are."""
        named = {"hot_plate": self.plate_line, "balance": self.balance}
        return {name: device.identity for name, device in named.items() if device is not None}


def make_peripherals(rig: RigDescription, clock: Clock, open_line: OpenLine, machine: VirtualMachine) -> Peripherals:
    """Make the devices around stage and pump; lines are opened, and nothing is said on them yet.

    Args:
        rig: description of the rig.
        clock: time that all of it shares.
        open_line: opens the lines of the hot plate and the balance, if there are such.
        machine: what is simulated is a part of this one.

    Raises:
        RigError: if a port cannot be opened.
    """
    file, heat = rig.file, rig.machine.heat

    def heated(thermostat: Thermostat, name: str, max_c: float) -> HeatedDevice:
        return HeatedDevice(thermostat, clock, name=name, temperature_c_max=max_c, limits=rig.heating_limits())

    extruder = lamp = hot_air = hot_plate = balance = plate_line = None
    if file.extruder == "simulated" and file.deposition is not None:
        extruder = PneumaticExtruder(machine.extruder, clock, flow_ml_min=file.deposition.flow_ml_min)
    if file.lamp == "simulated":
        lamp = SwitchedLamp(machine.lamp, clock, warm_up_s=file.curing.warm_up_s)
    if file.hot_air == "simulated":
        hot_air = heated(SimulatedThermostat(machine.hot_air, clock), "hot air", heat.hot_air_c_max)
    if file.hot_plate == "namur" and file.hot_plate_line is not None:
        line = open_line("hot_plate", file.hot_plate_line, "7E1", machine.plate)
        plate_line = NamurThermostat(line, watchdog_s=file.hot_plate_line.watchdog_s)
        hot_plate = heated(plate_line, "hot plate", heat.hot_plate_c_max)
    elif file.hot_plate == "simulated":
        hot_plate = heated(SimulatedThermostat(machine.hot_plate, clock), "hot plate", heat.hot_plate_c_max)
    if file.balance == "sics" and file.balance_line is not None:
        balance = SicsBalance(open_line("balance", file.balance_line, "8N1", machine.balance))
    return Peripherals(
        extruder=extruder,
        lamp=lamp,
        hot_air=hot_air,
        hot_plate=hot_plate,
        enclosure=machine.enclosure if file.enclosure == "simulated" else None,
        balance=balance,
        plate_line=plate_line,
    )
