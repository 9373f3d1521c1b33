"""A rig put together from its file: lines, drivers, simulated parts and prompts."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from math import inf
from pathlib import Path

from planner.errors import RigError
from rig.attended import OperatorEnclosure, OperatorExtruder, OperatorHotAir, OperatorHotPlate, OperatorLamp
from rig.devices import Operator
from rig.executor.machine import Devices
from rig.grbl_stage import GrblStage
from rig.machine_file import RigDescription
from rig.machine_sections import Line
from rig.marlin_stage import MarlinStage
from rig.peripherals import Controller, make_peripherals
from rig.pump_load import AuditedLoad, PumpLoad
from rig.transport import (
    Framing,
    LoggedTransport,
    PacedClock,
    SerialTransport,
    SimulatedTransport,
    Transport,
    VirtualClock,
    WallClock,
)
from rig.virtual.device import VirtualDevice
from rig.virtual.machine import VirtualMachine

Wrap = Callable[[Controller, Transport], Transport]
"""What is put around each line: a log, or faults and a log."""


@dataclass(frozen=True, kw_only=True)
class OpenRig:
    """A rig whose lines are open."""

    devices: Devices
    virtual: VirtualMachine
    """The simulated parts, as far as there are any."""
    lines: tuple[Transport, ...]

    def close(self) -> None:
        """Give all lines back."""
        for line in self.lines:
            with suppress(RigError):
                line.close()


def logged_in(folder: Path) -> Wrap:
    """Return what logs each line into a folder, as `wire-stage.jsonl`."""
    return lambda name, line: LoggedTransport(line, folder / f"wire-{name}.jsonl")


def open_rig(
    rig: RigDescription,
    operator: Operator,
    *,
    wrap: Wrap,
    load: float | AuditedLoad = 0.0,
    virtual: VirtualMachine | None = None,
) -> OpenRig:
    """Open the lines of a rig.

    Args:
        rig: what there is.
        operator: who works the devices without a line.
        wrap: what is put around each line.
        load: load in the chamber [g], or what was last audited.
        virtual: the simulated parts, if they were there before.

    Raises:
        RigError: if a port cannot be opened; then none stays open.
    """
    if virtual is None:
        pace = rig.file.simulated.pace or (1.0 if rig.file.has_serial_lines else 0.0)
        virtual = VirtualMachine(rig, PacedClock(pace) if pace else VirtualClock())
    clock = virtual.clock if rig.file.has_simulated else WallClock()
    lines: list[Transport] = []

    def open_line(name: Controller, line: Line, framing: Framing, device: VirtualDevice) -> Transport:
        lines.append(_open(line, framing, device, virtual.clock))
        lines.append(wrap(name, lines[-1]))
        return lines[-1]

    try:
        stage = _stage(rig, open_line("stage", rig.file.stage, "8N1", virtual.controller))
        pump = PumpLoad(open_line("pump", rig.file.pump, "8N1", virtual.pump), rig.pump_setup(), start=load)
        around = make_peripherals(rig, clock, open_line, virtual)
    except RigError:
        for line in lines:
            line.close()
        raise
    devices = Devices(
        clock=clock,
        stage=stage,
        load=pump,
        extruder=around.extruder or OperatorExtruder(operator),
        lamp=around.lamp or OperatorLamp(operator),
        hot_air=around.hot_air or OperatorHotAir(operator),
        hot_plate=around.hot_plate or OperatorHotPlate(operator),
        enclosure=around.enclosure or OperatorEnclosure(operator),
        operator=operator,
        balance=around.balance,
        gauge=virtual if rig.file.stage.transport == rig.file.pump.transport == "simulated" else None,
        audited_load=lambda: pump.audited,
        connect=around.connect,
        identities=lambda: {"stage": stage.identity, "pump": pump.identity, **around.identities()},
    )
    return OpenRig(devices=devices, virtual=virtual, lines=tuple(lines))


def _open(line: Line, framing: Framing, device: VirtualDevice, clock: VirtualClock) -> Transport:
    if line.transport == "simulated":
        return SimulatedTransport(device, clock)
    assert line.port is not None  # the file is refused without
    return SerialTransport(line.port, line.baud, framing=framing)


def _stage(rig: RigDescription, line: Transport) -> GrblStage | MarlinStage:
    limits, described = rig.machine.stage, rig.file.stage
    if described.controller == "marlin":
        return MarlinStage(line, limits=limits, controller=rig.marlin(), origin_mm=described.origin_mm)
    return GrblStage(
        line,
        limits=limits,
        controller=rig.grbl(),
        origin_mm=described.origin_mm,
        pace_tolerance_s=inf if described.pace_tolerance_s is None else described.pace_tolerance_s,
    )
