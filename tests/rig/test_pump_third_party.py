"""Others who speak the pump's language: `pip install --no-deps labmcp-new-era nesp-lib`; skipped where they are not.

What differs: `labmcp-new-era` knows only the basic mode and no PF. `nesp-lib` takes for granted that SAF is done even
by a pump with an alarm to tell, so that in safe mode it hangs on a pump just switched on, and it does not expect the
alarms that a pump in safe mode tells by itself.
"""

import sys
import time
from types import ModuleType
from typing import Any

import pytest

from planner.errors import RigError
from rig.pump_load import PumpLoad, PumpSetup
from rig.transport import VirtualClock
from rig.virtual.new_era import VirtualPump


@pytest.fixture
def simulator(monkeypatch: pytest.MonkeyPatch) -> Any:
    base: Any = ModuleType("labmcp")
    base.LineSimulator = object
    monkeypatch.setitem(sys.modules, "labmcp", base)
    return pytest.importorskip("labmcp_new_era.simulator").NewEraSimulator


class SimulatorLine:
    """Line to a simulator that takes whole lines."""

    def __init__(self, simulator: Any, clock: VirtualClock) -> None:
        self.clock = clock
        self._simulator = simulator
        self._inbox = b""
        self._outbox = b""

    def write(self, data: bytes) -> None:
        *lines, self._inbox = (self._inbox + data).split(b"\r")
        for line in lines:
            reply = self._simulator.handle(line.decode("latin-1"))
            self._outbox += b"" if reply is None else reply.encode() + b"\x03"

    def read(self, timeout_s: float) -> bytes:
        self.clock.sleep(0.01 if self._outbox else timeout_s)
        data, self._outbox = self._outbox, b""
        return data

    def close(self) -> None:
        pass


@pytest.mark.parametrize("diameter_mm", [15.9, 12.0])
def test_our_driver_doses_a_third_partys_pump(simulator: Any, diameter_mm: float) -> None:
    clock = VirtualClock()
    pump = simulator(clock=clock.now_s)
    setup = PumpSetup(syringe_diameter_mm=diameter_mm, rate_ml_min=5.0, ml_per_g=1.0, load_g_max=6.5, watchdog_s=0)
    load = PumpLoad(SimulatorLine(pump, clock), setup)
    for load_g in (1.5, 6.5, 0.25, 6.0):
        load.set_load(load_g)
        load.wait_settled(120.0)
        assert load.load_g() == pytest.approx(load_g, abs=0.001)
    assert sum(pump.dispensed.values()) == pytest.approx(5.75, abs=0.001)  # since the counters were last cleared
    pump.stall_after_ml = sum(pump.dispensed.values()) + 0.2
    load.set_load(5.0)
    with pytest.raises(RigError, match="stalled"):
        load.wait_settled(120.0)
    assert load.load_g() == pytest.approx(5.8, abs=0.001)


class HostPort:
    """What `nesp-lib` takes for a serial port, with our pump behind it and time running faster."""

    def __init__(self, pump: VirtualPump) -> None:
        self._pump = pump
        self._inbox = b""

    def _transmit(self, data: bytes) -> None:
        self._pump.receive(bytes(data), self._now_s())

    def _receive(self, data_length: int) -> bytes:
        give_up_s = time.monotonic() + 2.0
        while self._waiting_receive < data_length:
            assert time.monotonic() < give_up_s, "no answer"
        data, self._inbox = self._inbox[:data_length], self._inbox[data_length:]
        return data

    @property
    def _waiting_receive(self) -> int:
        self._inbox += self._pump.send(self._now_s())
        return len(self._inbox)

    def _now_s(self) -> float:
        return 100.0 * time.monotonic()


@pytest.mark.parametrize("safe_s", [0, 250])
def test_a_third_partys_driver_doses_our_pump(safe_s: int) -> None:
    nesp_lib = pytest.importorskip("nesp_lib")
    pump = VirtualPump(diameter_mm=15.9)
    if safe_s:
        pump.alarm = None
    host = nesp_lib.Pump(HostPort(pump), safe_mode_timeout_s=safe_s)
    assert (host.model_number, host.firmware_version) == (1000, (3, 923))
    host.syringe_diameter_mm = 12.0
    host.pumping_rate_ml_per_min = 5.0
    for direction, volume_ml in ((nesp_lib.PumpingDirection.INFUSE, 1.5), (nesp_lib.PumpingDirection.WITHDRAW, 0.25)):
        host.pumping_direction = direction
        host.pumping_volume_ml = volume_ml
        host.run()
    assert (host.volume_infused_ml, host.volume_withdrawn_ml) == (1.5, 0.25)
    assert pump.plunger.moved_ml == pytest.approx(1.25, abs=0.001)
    host.safe_mode_timeout_s = 0
    pump.stall_at_ml = pump.plunger.travelled_ml + 0.1
    with pytest.raises(nesp_lib.StatusAlarmException):
        host.run()
    assert pump.alarm is None  # told once
