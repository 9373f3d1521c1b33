"""The pump over a pseudo-terminal, in another process and in real time, hears what the simulated one hears."""

import os
import subprocess
import sys
import tty
from collections.abc import Iterator

import pytest

from rig.pump_load import PumpLoad, PumpSetup
from rig.transport import SerialTransport, SimulatedTransport, Transport, VirtualClock
from rig.virtual.new_era import VirtualPump

SERVER = """
import sys
from rig.transport.pty_server import serve
from rig.virtual.new_era import VirtualPump
print("ready", flush=True)
serve(VirtualPump(), int(sys.argv[1]))
"""
POLLS = ("0DIS", "0VER")
"""How often these are said depends on how fast the answers come."""


@pytest.fixture
def terminal() -> Iterator[str]:
    master, slave = os.openpty()
    tty.setraw(slave)
    command = [sys.executable, "-c", SERVER, str(master)]
    with subprocess.Popen(command, pass_fds=[master], stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        assert server.stdout.readline() == "ready\n"
        yield os.ttyname(slave)
        server.kill()
    os.close(master)
    os.close(slave)


def words_said(line: Transport, monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    said: list[bytes] = []
    write = line.write

    def overheard(data: bytes) -> None:
        said.append(data)
        write(data)

    monkeypatch.setattr(line, "write", overheard)
    setup = PumpSetup(
        syringe_diameter_mm=15.9, rate_ml_min=10.0, ml_per_g=1.0, load_g_max=6.5, watchdog_s=30, settle_s=0.0
    )
    load = PumpLoad(line, setup)
    for load_g in (0.04, 0.01):
        load.set_load(load_g)
        load.wait_settled(10.0)
        assert load.load_g() == pytest.approx(load_g, abs=0.001)
    line.close()
    return [data for data in said if not any(poll.encode() in data for poll in POLLS)]


def test_the_same_bytes_over_both_lines(terminal: str, monkeypatch: pytest.MonkeyPatch) -> None:
    simulated = words_said(SimulatedTransport(VirtualPump(), VirtualClock()), monkeypatch)
    serial = words_said(SerialTransport(terminal, 19200), monkeypatch)
    assert serial == simulated
