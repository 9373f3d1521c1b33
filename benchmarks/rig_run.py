"""How long a Program takes on the simulated rig, in wall and machine time: `python -m benchmarks rig_run [PLAN]`."""

import argparse
import tempfile
from pathlib import Path

from planner.plan import plan
from planner.program import Program, layer_times, load_program
from rig.executor.operations import list_operations
from rig.executor.session import run_session
from rig.machine_file import load_rig
from scenes.case import load_case


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("plan", nargs="?", type=Path, help="a plan's folder; default: the built-in face")
    chosen = parser.parse_args()
    program, rig = _program(chosen.plan), load_rig()
    with tempfile.TemporaryDirectory() as folder:
        ran = run_session(program, rig, Path(folder) / "run")
        sizes = {path.name: path.stat().st_size for path in sorted((Path(folder) / "run").iterdir())}
    times = layer_times(program, rig.machine)
    length_mm = sum(stroke.length_mm for layer in program.layers for stroke in layer.passes)
    rows = [
        ("operations", str(len(list_operations(program, rig.machine)))),
        ("scratched", f"{length_mm:.0f} mm"),
        ("machine time", f"{ran.run_s / 60:.1f} min"),
        ("of it scratching, by the model", f"{sum(time.total_s for time in times) / 60:.1f} min"),
        ("wall time", f"{ran.wall_s:.1f} s"),
        *((name, f"{size / 1e6:.1f} MB") for name, size in sizes.items()),
    ]
    for name, value in rows:
        print(f"{name:<32} {value}")


def _program(folder: Path | None) -> Program:
    if folder is not None:
        return load_program(folder)
    case = load_case("face")
    return plan(case.make_target(), **case.plan.model_dump()).program


if __name__ == "__main__":
    main()
