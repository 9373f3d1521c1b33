"""How the time and memory of a heating grow with the number of triangles, from flat to 150 C, with warm kernels.

python -m benchmarks growth [--triangles 2000 5000 ...] [--film ellipse|face] [--plain] [--device auto]
"""

import argparse
import json
import resource
import subprocess
import sys
import time
from contextlib import ExitStack

import numpy as np

from benchmarks.face import SHELL_METHODS, warm_up
from benchmarks.machine import describe_machine
from benchmarks.stopwatch import Stopwatch
from planner.plan import plan
from planner.target import mesh_outline, signed_area
from scenes.case import load_case
from twin.equilibrium.linear import PardisoSolver, SuperLuSolver
from twin.film import Film, FilmOptions, build_film, film_from_alignment
from twin.predict import PredictOptions, heat_film
from twin.shell import Shell

SIZES = (2_000, 5_000, 20_000, 60_000, 120_000)
CONTRACTION = 0.10


def azimuthal_ellipse(edge_mm: float) -> Film:
    """Film of 60 x 40 mm, bottom two layers scratched in circles around its middle."""
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    flat, triangles = mesh_outline(np.column_stack((30 * np.cos(angle), 20 * np.sin(angle))), edge_mm)
    centre = flat[triangles].mean(axis=1)
    double = 2 * np.arctan2(centre[:, 1], centre[:, 0]) + np.pi
    q = np.zeros((4, len(triangles), 2))
    q[:2] = CONTRACTION * np.column_stack((np.cos(double), np.sin(double)))
    return film_from_alignment(flat, triangles, q, layer_thickness_mm=np.full(4, 0.2))


def make_film(kind: str, triangles: int) -> Film:
    if kind == "ellipse":
        return azimuthal_ellipse(float(np.sqrt(4 / np.sqrt(3) * np.pi * 600 / triangles)))
    program = plan(load_case("face").make_target()).program
    area = abs(signed_area(np.asarray(program.cut.line_mm)))
    return build_film(program, FilmOptions(mesh_mm=float(np.sqrt(4 / np.sqrt(3) * area / triangles))))


def measure_one(kind: str, triangles: int, plain: bool, device: str) -> dict:
    warm_up(device)
    film = make_film(kind, triangles)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    watch = Stopwatch()
    started = time.perf_counter()
    with ExitStack() as stack:
        stack.enter_context(watch.measure_methods("kernels", Shell, *SHELL_METHODS))
        for solver in (PardisoSolver, SuperLuSolver):
            stack.enter_context(watch.measure_methods("factor", solver, "factorize"))
            stack.enter_context(watch.measure_methods("solve", solver, "solve"))
        shape = heat_film(film, PredictOptions(device=device, coarse_to_fine=not plain))
    return {
        "triangles": len(film.triangles),
        "seconds": time.perf_counter() - started,
        "parts": watch.seconds,
        "factorizations": watch.calls["factor"],
        "steps": shape.newton_iterations,
        "temperatures": len(shape.temperature_c) - 1,
        "residual": shape.relative_residual,
        "memory_gb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6,
        "memory_before_gb": before / 1e6,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--triangles", type=int, nargs="+", default=list(SIZES))
    parser.add_argument("--film", choices=("ellipse", "face"), default="ellipse")
    parser.add_argument("--plain", action="store_true", help="walk the whole ramp on the fine mesh")
    parser.add_argument("--device", default="auto")
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure_one(options.film, options.triangles[0], options.plain, options.device)))
        return
    way = "whole ramp on the fine mesh" if options.plain else "coarse to fine"
    print(f"Film: {options.film}, on the plate, {way}.\n")
    print("| triangles | heating s | kernels s | factorisations s | solves s | rest s | factorisations | Newton steps "
          "| temperatures | relative residual | peak memory GB |")  # fmt: skip
    print("|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|")
    rows = []
    for triangles in options.triangles:
        # a process of its own: peak memory only ever grows
        command = [sys.executable, "-m", "benchmarks", "growth", "--one", "--triangles", str(triangles)]
        command += ["--film", options.film, "--device", options.device, *(["--plain"] if options.plain else [])]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        row = json.loads(done.stdout.splitlines()[-1])
        rows.append(row)
        parts = row["parts"]
        rest = row["seconds"] - sum(parts.values())
        print(
            f"| {row['triangles']} | {row['seconds']:.1f} | {parts['kernels']:.1f} | {parts['factor']:.1f} "
            f"| {parts['solve']:.1f} | {rest:.1f} | {row['factorizations']} | {row['steps']} | {row['temperatures']} "
            f"| {row['residual']:.0e} | {row['memory_gb']:.1f} |",
            flush=True,
        )
    if len(rows) > 1:
        logs = np.log([[row["triangles"], row["seconds"]] for row in rows])
        print(f"\nTime grows as triangles^{np.polyfit(logs[:, 0], logs[:, 1], 1)[0]:.2f}.\n")
    for sentence in describe_machine():
        print(f"- {sentence}")


if __name__ == "__main__":
    main()
