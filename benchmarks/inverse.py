"""Design a Program for every surface of a folder by the inverse method; print Markdown tables of what it reaches.

python -m benchmarks inverse ../shared/targets [--only NAME ...] [--stack all|pairs] [--robust] [--budget-s S]
    [--noise N] [--noise-mesh-mm MM] [--pictures DIR]

Scores are those of the passes, heated from flat on the 0.6 mm mesh as `lce predict` does it; "ideal" is the smooth
fields that the passes trace. "to 0.95" is the time after which a film of passes first scored it.
"""

import argparse
import time
from pathlib import Path

import numpy as np

from benchmarks.face import warm_up
from benchmarks.machine import describe_machine
from planner.target import Target, load_target
from scenes.pictures import draw_design, draw_search
from scenes.prediction import PAPER_SSIM
from scenes.robustness import MESH_MM, score_noisy_films
from twin.batch import ProcessNoise
from twin.inverse import InverseDesign, InverseOptions, design_inverse

HEADER = (
    "| target | ssim_eq4 | RMS mm | % diag. | ideal ssim_eq4 | ideal RMS mm | coverage | overlap | "
    "off director deg, median / 95 % | passes | longest layer min | errors + warnings | to 0.95 s | all s |"
)
PASSES = ("passes", "finish")
NOISE_HEADER = "| target | mesh mm | without noise | 10 % | 50 % | 90 % | RMS mm, 90 % |"


def row(label: str, made: InverseDesign, wall_s: float) -> str:
    # passes of fields that were given up count as nothing: their films snap on their way from flat
    last_fields_s = max(moment.elapsed_s for moment in made.history if moment.stage not in PASSES)
    good = [own.elapsed_s for own in made.history if own.stage in PASSES and own.ssim >= 0.95]
    first = next((elapsed_s for elapsed_s in good if elapsed_s > last_fields_s), None)
    tilings, problems = made.tilings, made.problems
    cells = (
        label + ("" if made.shape.stable else ", unstable"),
        f"**{made.score.ssim_eq4:.3f}**",
        f"{made.score.rms_mm:.2f}",
        f"{made.score.rms_percent_of_diagonal:.2f}",
        f"{made.ideal.ssim_eq4:.3f}",
        f"{made.ideal.rms_mm:.2f}",
        f"{min(own.coverage for own in tilings):.1%}",
        f"{max(own.overlap for own in tilings):.1%}",
        f"{max(own.deviation_median_deg for own in tilings):.1f} / {max(own.deviation_95_deg for own in tilings):.1f}",
        " + ".join(str(own.passes) for own in tilings),
        f"{max(own.total_s for own in made.layer_times) / 60:.0f}",
        f"{sum(own.severity == 'error' for own in problems)} + {sum(own.severity == 'warning' for own in problems)}",
        "-" if first is None else f"{first:.0f}",
        f"{wall_s:.0f}",
    )
    return "| " + " | ".join(cells) + " |"


def noise_row(label: str, made: InverseDesign, target: Target, count: int, mesh_mm: float) -> str:
    found = score_noisy_films(made.program, target, InverseOptions().heated, ProcessNoise(), count, mesh_mm=mesh_mm)
    ssim = np.percentile([score.ssim_eq4 for score in found.scores], (10, 50, 90))
    rms = np.percentile([score.rms_mm for score in found.scores], 90)
    cells = label, f"{found.mesh_mm:g}", *(f"{value:.3f}" for value in (found.planned.ssim_eq4, *ssim)), f"{rms:.2f}"
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", nargs="+")
    parser.add_argument("--stack", choices=("all", "pairs"), default="all")
    parser.add_argument("--robust", action="store_true")
    parser.add_argument("--budget-s", type=float)
    parser.add_argument("--noise", type=int, default=0)
    parser.add_argument("--noise-mesh-mm", type=float, default=MESH_MM)
    parser.add_argument("--pictures", type=Path)
    options = parser.parse_args()
    warm_up("cpu")
    settings = InverseOptions(stack=options.stack, robust=options.robust, budget_s=options.budget_s)
    if options.pictures:
        options.pictures.mkdir(parents=True, exist_ok=True)
    print(HEADER)
    print("|---" * HEADER.count(" |") + "|", flush=True)
    noisy, limits, curves = [], [], []
    for path in sorted(options.folder.glob("*.npz")):
        if options.only and path.stem not in options.only:
            continue
        target, started = load_target(path), time.perf_counter()
        made = design_inverse(target, options=settings)
        print(row(path.stem, made, time.perf_counter() - started), flush=True)
        limits += [f"- {path.stem}: {sentence}" for sentence in made.limits]
        curves.append(
            f"- {path.stem}: " + ", ".join(f"{own.elapsed_s:.0f} s {own.stage} {own.ssim:.3f}" for own in made.history)
        )
        if options.pictures:
            draw_design(options.pictures / f"{path.stem}-inverse.png", target, made.scored)
            picture = options.pictures / f"{path.stem}-search.png"
            draw_search(picture, made.history, made.score, title=path.stem, paper_ssim=PAPER_SSIM)
        if options.noise:
            noisy.append(noise_row(path.stem, made, target, options.noise, options.noise_mesh_mm))
    for title, lines in (("Limits:", limits), ("Score over time:", curves)):
        print(f"\n{title}\n", *lines, sep="\n")
    if noisy:
        print(f"\n{options.noise} noisy films each:\n", NOISE_HEADER, "|---" * 7 + "|", *noisy, sep="\n")
    print("", *(f"- {sentence}" for sentence in describe_machine()), sep="\n")


if __name__ == "__main__":
    main()
