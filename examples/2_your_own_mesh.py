"""
Your own mesh
=============

From a surface in a file to a plan, a prediction and its score. With the command line it is::

    lce plan my_surface.stl --size-mm 26x20 --out out/plan
    lce predict out/plan --out out/hot
"""

# sphinx_gallery_thumbnail_number = 3
from pathlib import Path

import numpy as np
import trimesh

from planner.plan import plan
from planner.target import load_target
from scenes.pictures import draw_depth_images, draw_error_map, draw_plan, draw_target
from twin.film import FilmOptions
from twin.predict import PredictOptions, predict
from twin.score import score_surface

out = Path("out/your_own_mesh")
out.mkdir(parents=True, exist_ok=True)

# %%
# Any mesh will do: only the surface that is seen from above counts. This one, a leaf with a rib
# along its middle, is made here so that the example needs no file. Its unit is not the
# millimetre, as in many files.

u, v = np.meshgrid(np.linspace(-1, 1, 81), np.linspace(-1, 1, 61))
x, y = u, 0.75 * v * np.sqrt(1 - 0.98 * u**2)
z = 0.28 * (1 - u**2) * (1 - 0.5 * v**2) + 0.03 * np.exp(-((y / 0.12) ** 2))
corner = (81 * np.arange(60)[:, None] + np.arange(80)).ravel()
triangles = np.concatenate([corner[:, None] + (0, 1, 82), corner[:, None] + (0, 82, 81)])
trimesh.Trimesh(np.column_stack([x.ravel(), y.ravel(), z.ravel()]), triangles).export(out / "my_surface.stl")

# %%
# Load it, scaled evenly to fit into a box. What was done to the surface on the way is told in the
# target's notes.

target = load_target(out / "my_surface.stl", size_mm=(26.0, 20.0))
width_mm, height_mm = target.size_mm
print(f"{target.name}: {width_mm:.1f} x {height_mm:.1f} mm, {target.depth_mm:.1f} mm deep")
for note in target.notes:
    print(note)
draw_target(out / "target.png", target)

# %%
# Plan it. The findings of the preflight say whether the machine can do it, the layer times
# whether an uncured layer keeps its alignment until it is cured.

made = plan(target, seed=0)
for problem in made.problems:
    print(f"{problem.severity}: {problem.where}: {problem.message}")
for layer, time in zip(made.program.layers, made.layer_times, strict=True):
    print(f"layer {layer.index + 1}: {len(layer.passes)} passes, {time.total_s / 60:.0f} min")
draw_plan(out / "plan.png", made.program)

# %%
# Predict and score. The similarity of the paper, ``ssim_eq4``, is blind to smooth errors of
# height: read it with the RMS distance and the depth.

shape = predict(made.program, PredictOptions(film=FilmOptions(mesh_mm=1.0)))
scored = score_surface(shape.top_mm, shape.film.triangles, target)
score = scored.score
print(
    f"SSIM {score.ssim_eq4:.2f}, RMS {score.rms_mm:.2f} mm, {score.depth_mm:.1f} of {score.target_depth_mm:.1f} mm deep"
)
draw_error_map(
    out / "error.png",
    scored.vertices_mm,
    scored.triangles,
    scored.error_mm,
    rms_mm=score.rms_mm,
    hausdorff_mm=score.hausdorff_mm,
)

# %%
# The depth images that the similarity is taken of, and where they agree. The calibration behind
# all this is the placeholder: :doc:`the next but one example
# </gallery/4_calibrating_from_strips>` shows how to make your own.

draw_depth_images(out / "depth.png", target, scored.target_depth_mm, scored.shape_depth_mm, scored.ssim_map, score)
