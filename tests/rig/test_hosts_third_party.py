"""Others' hosts drive our virtual devices over a pseudo-terminal: `pip install pygrbl-streamer nesp-lib`; else skipped.

What differs from our drivers:

- `pygrbl-streamer` counts bytes as we do (127), but asks for no status while it streams, so that it notices a wrong
  position only if someone looks; it unlocks with `$X` when it connects, where we home; it skips a line that was
  refused unless told otherwise.
- `nesp-lib` blocks until an answer comes, for ever if none does; it asks for the status ten times a second while the
  pump runs, and does not look at the counters.
"""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from rig.heated_device import HeatedDevice
from rig.heating_watch import HeatingLimits
from rig.namur_plate import NamurThermostat
from rig.sics_balance import SicsBalance
from rig.transport import SerialTransport


@contextmanager
def terminal(device: str, *, speed: float) -> Iterator[str]:
    command = [sys.executable, "-m", "rig.transport.pty_server", device, "--speed", f"{speed:g}"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        try:
            yield server.stdout.readline().strip()
        finally:
            server.terminate()


def test_pygrbl_streamer_drives_our_controller() -> None:
    module = pytest.importorskip("pygrbl_streamer")
    said: list[str] = []
    with terminal("grbl", speed=20.0) as port:
        host = module.GrblStreamer(port, auto_unlock=False)
        host.receive_callback = said.append
        host.connect()
        try:
            assert host.home(timeout=30.0)
            assert host.command("G10L2P1X-100Y-100Z-30")
            lines = [f"G1X{0.1 * k:.1f}Y{0.05 * k:.2f}F600 ; step {k}" for k in range(1, 301)]
            assert host.stream(["G21G90", "(a comment)", "G1X0Y0Z0F1200", *lines], completion_timeout=30.0)
            host.realtime(b"?")
            assert host.stream(["G1X30Y15F600"], completion_timeout=30.0)
            raw = host.last_status["raw"]
            assert raw.startswith("<Idle|MPos:-70.000,-85.000,-30.000|Bf:15,128|")
            assert not [line for line in said if line.startswith(("error", "ALARM"))]
            assert not host.command("G1X300F600Q1")  # refused
            assert host.stream(["G1X300F600"], completion_timeout=10.0) is False  # leaves the travel: ALARM:2
            assert "ALARM:2" in said
            # Its time-outs are short for a busy machine; it may be asked as often as one likes.
            assert any(host.reset(unlock=True) for _ in range(3))
        finally:
            host.disconnect()


def test_nesp_lib_doses_our_pump_over_a_terminal() -> None:
    nesp_lib = pytest.importorskip("nesp_lib")
    with terminal("new-era", speed=20.0) as name, nesp_lib.Port(name, 19200) as port:
        host = nesp_lib.Pump(port)
        assert (host.model_number, host.firmware_version) == (1000, (3, 923))
        host.syringe_diameter_mm = 15.9
        host.pumping_rate_ml_per_min = 10.0
        for direction, volume_ml in (
            (nesp_lib.PumpingDirection.INFUSE, 1.5),
            (nesp_lib.PumpingDirection.WITHDRAW, 0.25),
        ):
            host.pumping_direction = direction
            host.pumping_volume_ml = volume_ml
            host.run()
        assert (host.volume_infused_ml, host.volume_withdrawn_ml) == (1.5, 0.25)


def test_our_own_hosts_of_the_laboratory_over_terminals() -> None:
    with terminal("namur", speed=30.0) as port:
        line = SerialTransport(port, 9600, framing="7E1")
        device = HeatedDevice(
            NamurThermostat(line, watchdog_s=1500),
            line.clock,
            name="hot plate",
            temperature_c_max=200.0,
            limits=HeatingLimits(),
        )
        device.set_temperature(60.0)
        device.wait_temperature(60.0)
        assert device.temperature_c() == pytest.approx(60.0, abs=2.5)
        device.turn_off()
        line.close()
    with terminal("sics", speed=20.0) as port:
        balance = SicsBalance(SerialTransport(port, 9600))
        assert balance.load_g() == pytest.approx(5.0, abs=0.005)
        balance.close()
