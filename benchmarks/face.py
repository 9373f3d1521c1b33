"""Where the time goes from the built-in face to its score and pictures, with warm kernels.

python -m benchmarks face [--mesh-mm 0.6] [--device auto]
"""

import argparse
import tempfile
from contextlib import ExitStack
from pathlib import Path

from benchmarks.machine import describe_machine
from benchmarks.stopwatch import StageClock, Stopwatch
from planner.calibration import load_calibration
from planner.plan import plan
from planner.strips import strip_program
from scenes.case import load_case
from scenes.pictures import draw_hot_shape, draw_plan, draw_target
from scenes.prediction import write_score_files
from twin.equilibrium.linear import PardisoSolver, SuperLuSolver
from twin.film import FilmOptions, build_film
from twin.predict import PredictOptions, heat_film, predict
from twin.score import score_surface
from twin.shell import Shell

ALLOWED_S = {"plan": 30.0, "predict": 90.0}
SHELL_METHODS = ("energy", "gradient", "hessian", "elastic_hessian", "driving_force")


def warm_up(device: str) -> None:
    """Compile or load the kernels and fault in the libraries by a small strip."""
    program = strip_program(load_calibration(), length_mm=6.0, width_mm=6.0, radius_mm=5.0)
    predict(program, PredictOptions(film=FilmOptions(mesh_mm=1.5), device=device))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mesh-mm", type=float, default=0.6)
    parser.add_argument("--device", default="auto")
    options = parser.parse_args()
    machine = describe_machine()
    warm_up(options.device)

    watch = Stopwatch()
    case = load_case("face")
    with watch.measure("target"):
        target = case.make_target()
    made = plan(target, method=case.plan.method, seed=case.plan.seed, progress=StageClock(watch, prefix="plan: "))
    settings = PredictOptions(
        film=FilmOptions(mesh_mm=options.mesh_mm),
        support=case.predict.support,
        seed=case.predict.seed,
        device=options.device,
    )
    with watch.measure("predict: mesh and raster"):
        film = build_film(made.program, settings.film)
    inner = Stopwatch()
    with ExitStack() as stack:
        stack.enter_context(inner.measure_methods("kernels", Shell, *SHELL_METHODS))
        for solver in (PardisoSolver, SuperLuSolver):
            stack.enter_context(inner.measure_methods("factorisations", solver, "factorize"))
            stack.enter_context(inner.measure_methods("solves", solver, "solve"))
        stack.enter_context(watch.measure("predict: heating"))
        shape = heat_film(film, settings)
    with watch.measure("predict: scoring"):
        scored = score_surface(shape.top_mm, film.triangles, target)
    with watch.measure("pictures"), tempfile.TemporaryDirectory() as folder:
        draw_target(Path(folder) / "target.png", target)
        draw_plan(Path(folder) / "plan.png", made.program)
        draw_hot_shape(Path(folder) / "hot_shape.png", scored.vertices_mm, film.triangles)
        write_score_files(Path(folder), target, scored)

    print(f"Built-in face, {options.mesh_mm:g} mm mesh: {len(film.triangles)} triangles, device {shape.device}, "
          f"{shape.newton_iterations} Newton steps, residual {shape.relative_residual:.1e}, "
          f"SSIM (Eq. 4) {scored.score.ssim_eq4:.3f}\n")  # fmt: skip
    print("| stage | s | calls |")
    print("|---|---:|---:|")
    for name, seconds in watch.seconds.items():
        print(f"| {name} | {seconds:.2f} | |")
        if name == "predict: heating":
            for part, inside in inner.seconds.items():
                print(f"| &nbsp;&nbsp;{part} | {inside:.2f} | {inner.calls[part]} |")
            print(f"| &nbsp;&nbsp;rest | {seconds - sum(inner.seconds.values()):.2f} | |")
    for part, allowed in ALLOWED_S.items():
        total = sum(seconds for name, seconds in watch.seconds.items() if name.startswith(f"{part}: "))
        print(f"| **{part}**, allowed {allowed:g} s | **{total:.2f}** | |")
    print()
    for sentence in machine:
        print(f"- {sentence}")


if __name__ == "__main__":
    main()
