"""The help texts under snapshot, and what help must not import. `LCE_REGEN=1` rewrites the snapshots."""

import difflib
import os
import subprocess
import sys
from pathlib import Path

import pytest
from rich.console import Console

from scenes.cli import app

SNAPSHOTS = Path(__file__).parent / "help"
COMMANDS = (
    "",
    "demo",
    "scenes",
    "new",
    "plan",
    "predict",
    "run",
    "score",
    "calibrate",
    "export",
    "film",
    "studio",
    "doctor",
    "schema",
)
HEAVY = {
    "numpy",
    "scipy",
    "warp",
    "pyvista",
    "vtk",
    "vtkmodules",
    "matplotlib",
    "trimesh",
    "igl",
    "pydantic",
    "skimage",
    "trame",
    "aiohttp",
}
WIDTH = 100


def help_text(command: str) -> str:
    """The help of a command at a fixed width, without colours or spaces at the ends of lines."""
    console = Console(width=WIDTH, color_system=None, force_terminal=False)
    with console.capture() as captured:
        app.help_print(command.split(), console=console)
    return "\n".join(line.rstrip() for line in captured.get().splitlines()) + "\n"


def differences(path: Path, found: str) -> str:
    """What differs between a snapshot and the text found, as a diff; empty where they are equal."""
    kept = path.read_text(encoding="utf-8") if path.exists() else ""
    lines = difflib.unified_diff(kept.splitlines(), found.splitlines(), path.name, "found", lineterm="")
    return "\n".join(lines)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_equals_its_snapshot(command):
    path, found = SNAPSHOTS / f"{command or 'lce'}.txt", help_text(command)
    if os.environ.get("LCE_REGEN"):
        path.write_text(found, encoding="utf-8")
    difference = differences(path, found)
    assert not difference, f"if this change is meant, run the tests with LCE_REGEN=1\n{difference}"


def test_the_comparator_can_fail(tmp_path):
    kept = tmp_path / "plan.txt"
    kept.write_text(help_text("plan").replace("--seed", "--sede"), encoding="utf-8")
    assert "+│    --seed" in differences(kept, help_text("plan"))
    assert differences(tmp_path / "absent.txt", help_text("plan"))


def test_every_command_has_a_snapshot_and_no_snapshot_is_left_over():
    commands = {name for name in app if not name.startswith("-")}
    assert commands == set(COMMANDS) - {""}
    assert {path.stem for path in SNAPSHOTS.iterdir()} == commands | {"lce"}


def test_help_imports_no_heavy_library():
    program = (
        "import sys\n"
        "from scenes.cli import app\n"
        "for command in sys.argv[1:]:\n"
        "    app(command.split(',') + ['--help'], result_action='return_value')\n"
        "print('imported', *sorted({name.partition('.')[0] for name in sys.modules}))\n"
    )
    found = subprocess.run(
        [sys.executable, "-c", program, *COMMANDS[1:]], capture_output=True, text=True, check=True, timeout=60
    )
    assert found.stderr == ""
    names = set(found.stdout.splitlines()[-1].split())
    assert "scenes" in names
    assert not names & HEAVY
