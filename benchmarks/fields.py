"""Heat the ideal fields of both curvature plans, weightless and on the plate: what passes are a copy of.

python -m benchmarks.fields ../shared/targets/ict_mean.npz [--mesh-mm 1.0] [--pictures DIR]
"""

import argparse
from pathlib import Path

import numpy as np
import shapely

from planner.alignment import bending_field
from planner.calibration import load_calibration
from planner.curvature import curvature_field
from planner.flattening import film_outline, flatten
from planner.target import load_target
from scenes.pictures import draw_hot_shape
from twin.film import film_of_field
from twin.material import Material
from twin.predict import PredictOptions, heat_film
from twin.score import score_surface

LAYERS_MM = np.full(4, 0.2)
RIM_MM = 1.0
"""Outer part of the flattened surface left away: there neighbours lie beyond the outline, as for the plans."""
CASES = (("weightless", "free", 0.5), ("plate, 0.5 MPa", "plate", 0.5), ("plate, 0.2 MPa", "plate", 0.2))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("target", type=Path)
    parser.add_argument("--mesh-mm", type=float, default=1.0)
    parser.add_argument("--pictures", type=Path)
    options = parser.parse_args()
    target = load_target(options.target)
    flat = flatten(target)
    outline = shapely.get_coordinates(shapely.Polygon(film_outline(flat)).buffer(-RIM_MM).exterior)[:-1]
    print("| ideal field of | loads | ssim_eq4 | own scale | RMS mm | depth mm | triangles |")
    print("|---|---|---|---|---|---|---|")
    for method in ("perpendicular", "maximum"):
        field = bending_field(curvature_field(target, method=method), flat, load_calibration())
        film = film_of_field(field, outline, options.mesh_mm, layer_thickness_mm=LAYERS_MM)
        for label, support, modulus in CASES:
            settings = PredictOptions(support=support, material=Material(modulus_mpa=modulus), device="cpu")
            shape = heat_film(film, settings)
            scored = score_surface(shape.top_mm, film.triangles, target)
            s = scored.score
            print(
                f"| {method} | {label} | {s.ssim_eq4:.3f} | {s.ssim_eq4_own_scale:.3f} | {s.rms_mm:.2f} "
                f"| {s.depth_mm:.1f} of {s.target_depth_mm:.1f} | {len(film.triangles)} |",
                flush=True,
            )
            if options.pictures:
                options.pictures.mkdir(parents=True, exist_ok=True)
                name = f"{method}-{support}-{modulus:g}.png"
                title = f"{method}, {label}"
                draw_hot_shape(options.pictures / name, scored.vertices_mm, film.triangles, title=title)


if __name__ == "__main__":
    main()
