"""Noisy films of the built-in face: heated one after the other against together, with warm kernels.

python -m benchmarks batch [--films 32] [--mesh-mm 1.2] [--lanes N] [--device auto]
"""

import argparse
import os
import time
from collections.abc import Callable
from contextlib import ExitStack
from itertools import combinations
from typing import NamedTuple
from unittest.mock import patch

import numpy as np

from benchmarks.face import warm_up
from benchmarks.machine import describe_machine
from benchmarks.stopwatch import Stopwatch
from planner.plan import plan
from scenes.case import load_case
from twin.batch import ProcessNoise, heat_films, noisy_films
from twin.equilibrium import rigid_distance_mm
from twin.equilibrium.linear import PardisoSolver, SuperLuSolver
from twin.film import FilmOptions, build_film
from twin.predict import HotShape, PredictOptions, heat_film
from twin.shell.worlds import Worlds


class Run(NamedTuple):
    shapes: list[HotShape]
    wall_s: float
    cpu_s: float
    watch: Stopwatch
    films_a_launch: float


def measure(heat: Callable[[], list[HotShape]]) -> Run:
    """Time a run and, added up over its threads, what kernels and solvers take."""
    watch, sizes, evaluate = Stopwatch(), [], Worlds.evaluate

    def counted(self, want, states):
        sizes.append(len(states))
        return evaluate(self, want, states)

    with ExitStack() as stack:
        stack.enter_context(patch.object(Worlds, "evaluate", counted))
        stack.enter_context(watch.measure_methods("kernels", Worlds, "evaluate"))
        for solver in (PardisoSolver, SuperLuSolver):
            stack.enter_context(watch.measure_methods("factorisations", solver, "factorize"))
            stack.enter_context(watch.measure_methods("solves", solver, "solve"))
        wall, cpu = time.perf_counter(), time.process_time()
        shapes = heat()
        return Run(shapes, time.perf_counter() - wall, time.process_time() - cpu, watch, float(np.mean(sizes)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--films", type=int, default=32)
    parser.add_argument("--mesh-mm", type=float, default=1.2)
    parser.add_argument("--lanes", type=int, default=None)
    parser.add_argument("--device", default="auto")
    chosen = parser.parse_args()
    machine = describe_machine()
    warm_up(chosen.device)

    case = load_case("face")
    program = plan(case.make_target(), method=case.plan.method, seed=case.plan.seed).program
    film = build_film(program, FilmOptions(mesh_mm=chosen.mesh_mm))
    options = PredictOptions(support=case.predict.support, seed=case.predict.seed, device=chosen.device)
    started = time.perf_counter()
    films = noisy_films(film, ProcessNoise(), chosen.films, seed=0)
    making = time.perf_counter() - started
    together = measure(lambda: heat_films(films, options, lanes=chosen.lanes))
    alone = measure(lambda: [heat_film(each, options) for each in films])

    print(
        f"{len(films)} noisy films of the built-in face, {chosen.mesh_mm:g} mm mesh: {len(film.triangles)} triangles, "
        f"device {alone.shapes[0].device}; drawing their errors took {making:.2f} s.\n"
    )
    print("| | one after the other | together |")
    print("|---|---:|---:|")
    for name, read in (
        ("wall s", lambda run: f"{run.wall_s:.1f}"),
        ("CPU s", lambda run: f"{run.cpu_s:.1f}"),
        ("kernels, wall s in all threads", lambda run: f"{run.watch.seconds['kernels']:.1f}"),
        ("factorisations", lambda run: f"{run.watch.seconds['factorisations']:.1f}"),
        ("solves", lambda run: f"{run.watch.seconds['solves']:.1f}"),
        ("launch groups", lambda run: f"{run.watch.calls['kernels']}"),
        ("films a launch", lambda run: f"{run.films_a_launch:.2f}"),
        ("Newton steps", lambda run: f"{sum(shape.newton_iterations for shape in run.shapes)}"),
    ):
        print(f"| {name} | {read(alone)} | {read(together)} |")
    apart = max(
        np.abs(one.hot_mm - other.hot_mm).max() for one, other in zip(alone.shapes, together.shapes, strict=True)
    )
    spread = [rigid_distance_mm(one.hot_mm, other.hot_mm) for one, other in combinations(together.shapes, 2)]
    print(
        f"\nTogether {alone.wall_s / together.wall_s:.2f} times faster, with {alone.cpu_s / together.cpu_s:.2f} times "
        f"less CPU time; the shapes are the same to {apart:.0e} mm. Two films of the batch differ by "
        f"{np.median(spread):.1f} mm (median), {max(spread):.1f} mm (most) where they differ most.\n"
    )
    for sentence in machine:
        print(f"- {sentence}")
    print(f"- Load average at the end: {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
