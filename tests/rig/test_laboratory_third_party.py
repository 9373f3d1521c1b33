"""Others who speak the laboratory's languages: `pip install --no-deps labmcp-ika labmcp-mettler-toledo`; else skipped.

What differs: `labmcp-ika`'s plate does not answer outside 20 to 1500 s of watchdog, never forgets its target at the
start, and a watchdog that ended the heating lets it be started again without switching it off. Its external sensor is
plugged in by default and then regulates the medium; here it is not. `labmcp-mettler-toledo`'s balance rests at once, so
that it never answers `S I`, and has four decimals.
"""

import sys
from types import ModuleType
from typing import Any

import pytest

from planner.errors import RigError
from rig.heated_device import HeatedDevice
from rig.heating_watch import HeatingLimits
from rig.namur_plate import NamurThermostat
from rig.sics_balance import SicsBalance
from rig.transport import VirtualClock


def simulators(monkeypatch: pytest.MonkeyPatch, module: str) -> Any:
    base: Any = ModuleType("labmcp")
    base.LineSimulator = object
    monkeypatch.setitem(sys.modules, "labmcp", base)
    return pytest.importorskip(f"{module}.simulator")


class SimulatorLine:
    """Line to a simulator that takes whole lines."""

    def __init__(self, simulator: Any, clock: VirtualClock) -> None:
        self.clock = clock
        self._simulator = simulator
        self._inbox = b""
        self._outbox = b""

    def write(self, data: bytes) -> None:
        *lines, self._inbox = (self._inbox + data).split(b"\r\n")
        for line in lines:
            reply = self._simulator.handle(line.decode("ascii"))
            self._outbox += b"" if reply is None else f"{reply}\r\n".encode()

    def read(self, timeout_s: float) -> bytes:
        self.clock.sleep(0.01 if self._outbox else timeout_s)
        data, self._outbox = self._outbox, b""
        return data

    def close(self) -> None:
        pass


def test_our_driver_heats_a_third_partys_plate(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = VirtualClock()
    plate = simulators(monkeypatch, "labmcp_ika").IKASimulator(clock=clock.now_s)
    plate.external_probe = False
    thermostat = NamurThermostat(SimulatorLine(plate, clock), watchdog_s=60)
    device = HeatedDevice(thermostat, clock, name="hot plate", temperature_c_max=200.0, limits=HeatingLimits())
    device.set_temperature(150.0)
    assert thermostat.identity == "RCT digital"
    device.wait_temperature(1500.0)
    for _ in range(60):
        clock.sleep(10.0)
        assert device.temperature_c() == pytest.approx(150.0, abs=3.0)
    assert (plate.heating, plate.wd_tripped, plate.wd_mode) == (True, False, 1)
    clock.sleep(600.0)  # the host is gone: the plate's own watchdog
    with pytest.raises(RigError, match="was not read for"):
        device.temperature_c()
    assert (plate.heating, plate.wd_tripped) == (False, True)
    plate.safety_temp_c = 90.0
    with pytest.raises(RigError, match="stays 90 C where 120 C were set"):
        device.set_temperature(120.0)
    assert not plate.heating


def test_our_driver_reads_a_third_partys_balance(monkeypatch: pytest.MonkeyPatch) -> None:
    model = simulators(monkeypatch, "labmcp_mettler_toledo").MTSICSSimulator(load_g=35.25)
    balance = SicsBalance(SimulatorLine(model, VirtualClock()))
    balance.zero()
    assert balance.identity == "B123456789"
    model.load_g += 6.5
    assert balance.load_g() == pytest.approx(6.5, abs=1e-3)
    model.load_g = 500.0
    with pytest.raises(RigError, match="overloaded"):
        balance.load_g()
