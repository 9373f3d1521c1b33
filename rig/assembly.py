"""A rig put together from its file: lines, drivers, simulated parts and prompts."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from planner.errors import RigError
from rig.attended import OperatorEnclosure, OperatorExtruder, OperatorHotAir, OperatorHotPlate, OperatorLamp
from rig.devices import Operator
from rig.executor.machine import Devices
from rig.grbl_stage import GrblStage
from rig.machine_file import Line, RigDescription
from rig.pump_load import AuditedLoad, PumpLoad
from rig.transport import LoggedTransport, SerialTransport, Transport, VirtualClock, WallClock
from rig.virtual.machine import PacedClock, VirtualMachine

Controller = Literal["stage", "pump"]
Wrap = Callable[[Controller, Transport], Transport]
"""What is put around each line: a log, or faults and a log."""


@dataclass(frozen=True, kw_only=True)
class OpenRig:
    """A rig whose lines are open."""

    devices: Devices
    virtual: VirtualMachine | None
    """The simulated parts, if there are any."""
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
    file = rig.file
    real = "serial" in (file.stage.transport, file.pump.transport)
    if virtual is None:
        pace = file.simulated.pace or (1.0 if real else 0.0)
        virtual = VirtualMachine(rig, PacedClock(pace) if pace else VirtualClock())
    lines: list[Transport] = []
    try:
        lines.append(wrap("stage", _open(file.stage, virtual.stage_line)))
        lines.append(wrap("pump", _open(file.pump, virtual.pump_line)))
    except RigError:
        for line in lines:
            line.close()
        raise
    stage = GrblStage(lines[0], limits=rig.machine.stage, controller=rig.controller(), origin_mm=file.stage.origin_mm)
    pump = PumpLoad(lines[1], rig.pump_setup(), start=load)
    whole = file.stage.transport == file.pump.transport == "simulated"
    devices = Devices(
        clock=WallClock() if real and not _parts(rig) else virtual.clock,
        stage=stage,
        load=pump,
        extruder=OperatorExtruder(operator) if file.extruder == "operator" else virtual.extruder,
        lamp=OperatorLamp(operator) if file.lamp == "operator" else virtual.lamp,
        hot_air=OperatorHotAir(operator) if file.hot_air == "operator" else virtual.hot_air,
        hot_plate=OperatorHotPlate(operator) if file.hot_plate == "operator" else virtual.hot_plate,
        enclosure=OperatorEnclosure(operator) if file.enclosure == "operator" else virtual.enclosure,
        operator=operator,
        gauge=virtual if whole else None,
        audited_load=lambda: pump.audited,
        identities=lambda: {"stage": stage.identity, "pump": pump.identity},
    )
    return OpenRig(devices=devices, virtual=virtual, lines=tuple(lines))


def _open(line: Line, simulated: Callable[[], Transport]) -> Transport:
    if line.transport == "simulated":
        return simulated()
    assert line.port is not None  # the file is refused without
    return SerialTransport(line.port, line.baud)


def _parts(rig: RigDescription) -> bool:
    """Tell whether anything of a rig is simulated."""
    file = rig.file
    lines = file.stage.transport, file.pump.transport
    return "simulated" in lines or len(file.attended) < 5
