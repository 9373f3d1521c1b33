"""The devices that a rig's file makes, on one clock."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from planner.errors import InputError
from rig.devices import Balance, Enclosure, Extruder, HotAir, HotPlate, UvLamp
from rig.machine_file import SIMULATED_RIG, Line, load_rig
from rig.peripherals import Peripherals, make_peripherals
from rig.transport import SimulatedTransport, Transport, VirtualClock, WallClock
from rig.virtual.device import VirtualDevice

PLATE_AND_BALANCE = """
[hot_plate_line]
transport = "simulated"

[balance_line]
transport = "simulated"
"""


def made(path: Path | None = None) -> tuple[Peripherals, VirtualClock, list[tuple[str, str]]]:
    clock, opened = VirtualClock(), list[tuple[str, str]]()

    def open_line(name: str, line: Line, framing: str, device: Callable[[], VirtualDevice]) -> Transport:
        opened.append((name, framing))
        return SimulatedTransport(device(), clock)

    generator = np.random.default_rng(0)
    found = make_peripherals(load_rig(path), clock, open_line, pan_g=lambda _: 5.0, generator=generator)
    return found, clock, opened


def test_the_simulated_rig_has_them_all_and_one_time() -> None:
    devices, clock, opened = made()
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
    clock.sleep(180.0)
    devices.lamp.turn_off()
    assert devices.models.lamp is not None
    assert devices.models.lamp.dose_s() == pytest.approx(180.0)
    assert devices.hot_air.temperature_c() == pytest.approx(120.0, abs=2.5)
    with pytest.raises(InputError, match=r"hot plate: temperature_c is 250, allowed is above 0 to 200"):
        devices.hot_plate.set_temperature(250.0)


def test_lines_are_opened_where_the_file_says_so(tmp_path: Path) -> None:
    text = SIMULATED_RIG.read_text().replace('hot_plate = "simulated"', 'hot_plate = "namur"')
    text = text.replace('balance = "none"', 'balance = "sics"').replace('lamp = "simulated"', 'lamp = "operator"')
    path = tmp_path / "RIG.toml"
    path.write_text(text + PLATE_AND_BALANCE)
    devices, clock, opened = made(path)
    assert opened == [("hot_plate", "7E1"), ("balance", "8N1")]
    assert devices.lamp is None
    assert isinstance(devices.balance, Balance)
    assert devices.balance.load_g() == pytest.approx(5.0, abs=0.005)
    assert devices.hot_plate is not None
    devices.hot_plate.set_temperature(150.0)
    devices.hot_plate.wait_temperature(600.0)
    assert devices.models.hot_plate is not None
    assert devices.models.hot_plate.body_c(clock.now_s()) == pytest.approx(150.0, abs=3.0)


def test_a_simulated_device_beside_real_ones_lives_in_the_walls_time() -> None:
    clock = WallClock()

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
