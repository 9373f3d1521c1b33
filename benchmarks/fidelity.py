"""Plan and predict every surface of a folder with both methods of the paper; print a Markdown table of the scores.

python -m benchmarks.fidelity ../shared/targets [--mesh-mm 0.6] [--pictures DIR]
"""

import argparse
import time
import warnings
from pathlib import Path

from planner.plan import plan
from planner.target import Target, load_target
from scenes.pictures import draw_depth_images, draw_hot_shape
from twin.film import FilmOptions
from twin.predict import PredictOptions, predict
from twin.score import score_surface

METHODS = ("perpendicular", "maximum")
HEADER = (
    "| target | method | ssim_eq4 | own scale | inside | gauss | RMS mm | % diag. | Hausdorff mm | depth mm | "
    "clamped tight / wide | passes convex + concave | longest layer min | triangles | steps | plan s | predict s |"
)


def row(target: Target, label: str, method: str, mesh_mm: float, pictures: Path | None) -> str:
    started = time.perf_counter()
    made = plan(target, method=method)
    planned = time.perf_counter()
    shape = predict(made.program, PredictOptions(film=FilmOptions(mesh_mm=mesh_mm), device="cpu"))
    scored = score_surface(shape.top_mm, shape.film.triangles, target)
    predicted = time.perf_counter()
    if pictures is not None:
        draw_hot_shape(
            pictures / f"{label}-{method}.png", scored.vertices_mm, scored.triangles, title=f"{label}, {method}"
        )
        draw_depth_images(
            pictures / f"{label}-{method}-depth.png",
            target,
            scored.target_depth_mm,
            scored.shape_depth_mm,
            scored.ssim_map,
            scored.score,
        )
    s = scored.score
    passes = " + ".join(str(len(made.program.layers[index].passes)) for index in (0, -1))
    flags = "" if shape.stable else ", unstable"
    flags += f", tapped at {shape.tapped_away_at_c[0]:.0f} C" if shape.tapped_away_at_c else ""
    minutes = max(time.total_s for time in made.layer_times) / 60
    cells = (
        label,
        method + flags,
        f"**{s.ssim_eq4:.3f}**",
        f"{s.ssim_eq4_own_scale:.3f}",
        f"{s.ssim_eq4_inside:.3f}",
        f"{s.ssim_gauss:.3f}",
        f"{s.rms_mm:.2f}",
        f"{s.rms_percent_of_diagonal:.2f}",
        f"{s.hausdorff_mm:.1f}",
        f"{s.depth_mm:.1f} of {s.target_depth_mm:.1f}",
        f"{made.clamped_tight_share:.0%} / {made.clamped_wide_share:.0%}",
        passes,
        f"{minutes:.0f}",
        str(len(shape.film.triangles)),
        str(shape.newton_iterations),
        f"{planned - started:.0f}",
        f"{predicted - planned:.0f}",
    )
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--mesh-mm", type=float, default=0.6)
    parser.add_argument("--pictures", type=Path)
    options = parser.parse_args()
    warnings.simplefilter("error")
    if options.pictures:
        options.pictures.mkdir(parents=True, exist_ok=True)
    print(HEADER)
    print("|" + "---|" * (HEADER.count("|") - 1))
    for path in sorted((*options.folder.glob("*.npz"), *options.folder.glob("*.stl"))):
        target = load_target(path)
        label = path.stem if path.suffix == ".npz" else path.name
        for method in METHODS:
            print(row(target, label, method, options.mesh_mm, options.pictures), flush=True)


if __name__ == "__main__":
    main()
