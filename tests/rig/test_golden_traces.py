"""The simulated rig and a serial one, over terminals to virtual controllers in other processes, hear the same bytes."""

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from benchmarks.reliability.small_run import small_program
from planner.calibration import load_calibration
from planner.plan import plan
from planner.program import Cure, Layer, Program, ResetAlignment, Scratch
from planner.strips import strip_program
from rig.executor.prompts import SimulatedOperator
from rig.executor.session import run_session
from rig.machine_file import SIMULATED_RIG, RigDescription, load_rig
from scenes.case import list_cases, load_case
from scenes.case_target import Strip

SPEED = 100
"""Time of the controllers over the wall's."""
PASSES = 2
POLLS = ("0DIS", "0VER")
"""How often these are said, and the stage's `?`, depends on how fast the answers come."""


@contextmanager
def served(name: str) -> Iterator[str]:
    command = [sys.executable, "-m", "rig.transport.pty_server", name, "--speed", str(SPEED)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        try:
            yield server.stdout.readline().strip()
        finally:
            server.terminate()


def rig_file(folder: Path, stage: str | None = None, pump: str | None = None) -> RigDescription:
    text = SIMULATED_RIG.read_text().replace("settle_s = 1.0", "settle_s = 0")
    # In the pump's fast time the watchdog of 30 s would run out between two questions.
    text = text.replace("watchdog_s = 30", "watchdog_s = 255")
    for name, port in (("stage", stage), ("pump", pump)):
        line = f'[{name}]\ntransport = "simulated"'
        assert line in text
        if port is not None:
            text = text.replace(line, f'[{name}]\ntransport = "serial"\nport = "{port}"')
            text = text.replace("pace = 0.0", f"pace = {SPEED}")
    path = folder / f"{'serial' if stage else 'simulated'}.toml"
    path.write_text(text)
    return load_rig(path)


def said(folder: Path) -> dict[str, list[str]]:
    """What was written to each line, without questions whose number depends on the clock."""
    lines = {}
    for name in ("stage", "pump"):
        entries = [json.loads(text) for text in (folder / f"wire-{name}.jsonl").read_text().splitlines()]
        written = [entry["bytes"].replace("?", "") for entry in entries if entry["way"] == "out"]
        written = [data for data in written if data and not any(poll in data for poll in POLLS)]
        lines[name] = written if name == "pump" else ["".join(written)]
    return lines


def shortened(program: Program) -> Program:
    """The first passes of each layer, and short waits."""
    layers = []
    for layer in program.layers:
        operations = tuple(
            Scratch(passes=operation.passes[:PASSES])
            if isinstance(operation, Scratch)
            else operation.model_copy(
                update={"duration_s": 1.0} if isinstance(operation, ResetAlignment | Cure) else {}
            )
            for operation in layer.operations
        )
        layers.append(Layer(index=layer.index, operations=operations))
    return program.model_copy(update={"layers": tuple(layers)})


def program_of(name: str) -> Program:
    case = load_case(name)
    if isinstance(case.target, Strip):
        strip = case.target
        return strip_program(
            load_calibration(), length_mm=strip.length_mm, width_mm=strip.width_mm, radius_mm=strip.bending_radius_mm
        )
    return plan(case.make_target(), **case.plan.model_dump()).program


def check_traces(folder: Path, program: Program) -> None:
    run_session(program, rig_file(folder), folder / "simulated", operator=SimulatedOperator())
    with ExitStack() as servers:
        ports = [servers.enter_context(served(name)) for name in ("grbl", "new-era")]
        run_session(program, rig_file(folder, *ports), folder / "serial", operator=SimulatedOperator())
    simulated, serial = said(folder / "simulated"), said(folder / "serial")
    assert "G1" in simulated["stage"][0]
    assert any("RUN" in data for data in simulated["pump"])
    assert serial == simulated


def test_a_small_run_over_terminals(tmp_path: Path) -> None:
    program = shortened(small_program())
    top = tuple(
        Scratch(passes=tuple(stroke.model_copy(update={"load_g": stroke.load_g[:1]}) for stroke in operation.passes))
        if isinstance(operation, Scratch)
        else operation
        for operation in program.layers[1].operations
    )
    check_traces(tmp_path, program.model_copy(update={"layers": (program.layers[0], Layer(index=1, operations=top))}))


@pytest.mark.slow
@pytest.mark.parametrize("name", [case.name for case in list_cases()])
def test_every_scene_over_terminals(tmp_path: Path, name: str) -> None:
    check_traces(tmp_path, program_of(name))
