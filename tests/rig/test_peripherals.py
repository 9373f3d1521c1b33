"""The devices that a rig's file makes, on one clock."""

from pathlib import Path

import pytest

from planner.errors import InputError
from rig.devices import Balance, Enclosure, Extruder, HotAir, HotPlate, UvLamp
from rig.machine_file import SIMULATED_RIG, load_rig
from rig.machine_sections import Line
from rig.peripherals import Peripherals, make_peripherals
from rig.transport import PacedClock, SimulatedTransport, Transport, VirtualClock
from rig.virtual.device import VirtualDevice
from rig.virtual.machine import VirtualMachine

PLATE_AND_BALANCE = """
[hot_plate_line]
transport = "simulated"

[balance_line]
transport = "simulated"
at_mm = [70.0, 0.0]
pan_mm = 1.0
"""


def made(path: Path | None = None) -> tuple[Peripherals, VirtualMachine, list[tuple[str, str]]]:
    clock, opened = VirtualClock(), list[tuple[str, str]]()
    machine = VirtualMachine(load_rig(path), clock)

    def open_line(name: str, line: Line, framing: str, device: VirtualDevice) -> Transport:
        opened.append((name, framing))
        return SimulatedTransport(device, clock)

    return make_peripherals(load_rig(path), clock, open_line, machine), machine, opened


def test_the_simulated_rig_has_them_all_and_one_time() -> None:
    devices, machine, opened = made()
    assert opened == []
    assert isinstance(devices.extruder, Extruder)
    assert isinstance(devices.lamp, UvLamp)
    assert isinstance(devices.hot_air, HotAir)
    assert isinstance(devices.hot_plate, HotPlate)
    assert isinstance(devices.enclosure, Enclosure)
    assert devices.balance is None
    devices.hot_air.set_temperature(120.0)
    devices.hot_air.wait_temperature(120.0)
    devices.lamp.turn_on()
    machine.clock.sleep(180.0)
    devices.lamp.turn_off()
    assert machine.lamp.dose_s() == pytest.approx(180.0)
    assert devices.hot_air.temperature_c() == pytest.approx(120.0, abs=2.5)
    with pytest.raises(InputError, match=r"hot plate: temperature_c is 250, allowed is above 0 to 200"):
        devices.hot_plate.set_temperature(250.0)


def test_lines_are_opened_where_the_file_says_so(tmp_path: Path) -> None:
    text = SIMULATED_RIG.read_text().replace('hot_plate = "simulated"', 'hot_plate = "namur"')
    text = text.replace('balance = "none"', 'balance = "sics"').replace('lamp = "simulated"', 'lamp = "operator"')
    path = tmp_path / "RIG.toml"
    path.write_text(text + PLATE_AND_BALANCE)
    devices, machine, opened = made(path)
    assert opened == [("hot_plate", "7E1"), ("balance", "8N1")]
    assert devices.lamp is None
    assert isinstance(devices.balance, Balance)
    assert devices.balance.load_g() == pytest.approx(0.0, abs=0.005)
    devices.connect()
    assert devices.identities() == {"hot_plate": "C-MAG HS7", "balance": "B021002593"}
    assert devices.hot_plate is not None
    devices.hot_plate.set_temperature(150.0)
    devices.hot_plate.wait_temperature(600.0)
    assert machine.hot_plate.body_c(machine.clock.now_s()) == pytest.approx(150.0, abs=3.0)


def test_a_simulated_device_beside_real_ones_lives_in_the_walls_time() -> None:
    clock = PacedClock(1.0)

    class Beat:
        """Says one byte 20 ms after it heard one."""

        def __init__(self) -> None:
            self.due_s = float("inf")

        def receive(self, data: bytes, now_s: float) -> None:
            self.due_s = now_s + 0.02

        def send(self, now_s: float) -> bytes:
            if now_s < self.due_s:
                return b""
            self.due_s = float("inf")
            return b"!"

        def next_event_s(self, now_s: float) -> float:
            return self.due_s

    line = SimulatedTransport(Beat(), clock)
    before_s = clock.now_s()
    line.write(b"?")
    assert line.read(10.0) == b"!"
    assert clock.now_s() - before_s >= 0.02
    assert line.read(0.01) == b""
