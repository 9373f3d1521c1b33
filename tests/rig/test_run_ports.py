"""Ports that are not what the rig's file says: a run tells it before anything moves."""

import os
import tty
from collections.abc import Iterator
from pathlib import Path

import pytest
import serial

from benchmarks.reliability.scene import as_run_records
from benchmarks.reliability.small_run import small_program
from planner.errors import RigError
from rig.executor.prompts import SimulatedOperator
from rig.executor.session import run_session
from rig.machine_file import SIMULATED_RIG, RigDescription, load_rig
from rig.transport import SimulatedTransport, Transport
from rig.virtual.new_era import VirtualPump


@pytest.fixture
def terminal() -> Iterator[str]:
    master, slave = os.openpty()
    tty.setraw(slave)
    yield os.ttyname(slave)
    os.close(master)
    os.close(slave)


def rig_with(folder: Path, port: str) -> RigDescription:
    text = SIMULATED_RIG.read_text().replace(
        '[stage]\ntransport = "simulated"', f'[stage]\ntransport = "serial"\nport = "{port}"'
    )
    path = folder / "RIG.toml"
    path.write_text(text)
    return load_rig(path)


def run(folder: Path, port: str) -> None:
    run_session(small_program(), rig_with(folder, port), folder / "run", operator=SimulatedOperator())


def test_a_port_that_another_program_has(tmp_path: Path, terminal: str) -> None:
    with serial.Serial(terminal, exclusive=True), pytest.raises(RigError, match=f"{terminal} cannot be opened"):
        run(tmp_path, terminal)


def test_a_pump_on_the_stages_port(tmp_path: Path) -> None:
    def wrong(name: str, line: Transport) -> Transport:
        assert isinstance(line, SimulatedTransport)
        return SimulatedTransport(VirtualPump(), line.clock) if name == "stage" else line

    with pytest.raises(RigError, match=r"which port the stage is on|does not answer"):
        run_session(small_program(), load_rig(), tmp_path / "run", wrap=wrong)
    records = as_run_records(tmp_path / "run")
    assert not any(record["record"] == "operation" for record in records)
    assert records[-1]["outcome"] == "failed"
    # nothing was begun, so that the folder can be used once the port is right
    assert run_session(small_program(), load_rig(), tmp_path / "run").sessions == 1
