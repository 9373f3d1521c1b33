"""The devices around stage and pump, as a rig's file describes them; what an operator does is left out."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from numpy.random import Generator

from rig.extruder import PneumaticExtruder
from rig.heated_device import HeatedDevice, Thermostat
from rig.lamp import SwitchedLamp
from rig.machine_file import Line, RigDescription
from rig.namur_plate import NamurThermostat
from rig.sics_balance import SicsBalance
from rig.transport import Clock, Framing, Transport
from rig.virtual.balance import VirtualBalance
from rig.virtual.device import VirtualDevice
from rig.virtual.enclosure import VirtualEnclosure
from rig.virtual.extruder import VirtualExtruder
from rig.virtual.heater import VirtualHeater
from rig.virtual.lamp import VirtualLamp
from rig.virtual.namur import VirtualNamurPlate
from rig.virtual.thermostat import SimulatedThermostat

OpenLine = Callable[[str, Line, Framing, Callable[[], VirtualDevice]], Transport]
"""Opens a line: its name, its description, how its bytes are framed, and what is at its end if it is simulated."""

AIR_RATE_C_S: Final = 5.0
"""A gun's air warms faster than a plate [C/s]."""


@dataclass(kw_only=True)
class PeripheralModels:
    """What is simulated of the peripherals: the truth behind the drivers, and its faults."""

    extruder: VirtualExtruder | None = None
    lamp: VirtualLamp | None = None
    hot_air: VirtualHeater | None = None
    hot_plate: VirtualHeater | None = None
    enclosure: VirtualEnclosure | None = None


@dataclass(frozen=True, kw_only=True)
class Peripherals:
    """The devices around stage and pump; None where an operator does it, or none is there."""

    extruder: PneumaticExtruder | None
    lamp: SwitchedLamp | None
    hot_air: HeatedDevice | None
    hot_plate: HeatedDevice | None
    enclosure: VirtualEnclosure | None
    balance: SicsBalance | None
    models: PeripheralModels = field(default_factory=PeripheralModels)


def make_peripherals(
    rig: RigDescription,
    clock: Clock,
    open_line: OpenLine,
    *,
    pan_g: Callable[[float], float],
    generator: Generator,
) -> Peripherals:
    """Make the devices around stage and pump; lines are opened, and nothing is said on them yet.

    Args:
        rig: description of the rig.
        clock: time that all of it shares.
        open_line: opens the lines of the hot plate and the balance, if there are such.
        pan_g: weight on the pan of a simulated balance at a time [g].
        generator: source of its noise.

    Raises:
        RigError: if a port cannot be opened.
    """
    file, models = rig.file, PeripheralModels()
    extruder = lamp = hot_air = hot_plate = balance = None
    if file.extruder == "simulated" and file.deposition is not None:
        models.extruder = VirtualExtruder(clock, flow_ml_min=file.deposition.flow_ml_min)
        extruder = PneumaticExtruder(models.extruder, clock, flow_ml_min=file.deposition.flow_ml_min)
    if file.lamp == "simulated":
        models.lamp = VirtualLamp(clock, tau_s=file.curing.warm_up_s / 5)
        lamp = SwitchedLamp(models.lamp, clock, warm_up_s=file.curing.warm_up_s)
    if file.enclosure == "simulated":
        models.enclosure = VirtualEnclosure()
    heat = rig.machine.heat
    if file.hot_air == "simulated":
        models.hot_air = VirtualHeater(rate_c_s=AIR_RATE_C_S)
        hot_air = _heated(SimulatedThermostat(models.hot_air, clock), clock, rig, "hot air", heat.hot_air_c_max)
    if file.hot_plate != "operator":
        thermostat = _plate(rig, clock, open_line, models)
        hot_plate = _heated(thermostat, clock, rig, "hot plate", heat.hot_plate_c_max)
    if file.balance_line is not None and file.balance == "sics":
        balance = SicsBalance(
            open_line("balance", file.balance_line, "8N1", lambda: VirtualBalance(pan_g, generator)),
        )
    return Peripherals(
        extruder=extruder,
        lamp=lamp,
        hot_air=hot_air,
        hot_plate=hot_plate,
        enclosure=models.enclosure,
        balance=balance,
        models=models,
    )


def _plate(rig: RigDescription, clock: Clock, open_line: OpenLine, models: PeripheralModels) -> Thermostat:
    heater, line = VirtualHeater(), rig.file.hot_plate_line
    simulated = line is None or line.transport == "simulated"
    models.hot_plate = heater if simulated else None
    if line is None or rig.file.hot_plate == "simulated":
        return SimulatedThermostat(heater, clock)
    transport = open_line("hot_plate", line, "7E1", lambda: VirtualNamurPlate(heater))
    return NamurThermostat(transport, watchdog_s=line.watchdog_s)


def _heated(thermostat: Thermostat, clock: Clock, rig: RigDescription, name: str, max_c: float) -> HeatedDevice:
    return HeatedDevice(thermostat, clock, name=name, temperature_c_max=max_c, limits=rig.heating_limits())
