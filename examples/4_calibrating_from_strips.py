"""
Calibrating from strips
=======================

The map from the post's load and speed to a bending radius is your machine's, not ours: the one
that ships is a placeholder. Scratch about twenty strips, cut them out, heat them to 150 C,
measure how far they bend, and fit the map. With the command line::

    lce calibrate strips.csv --out calibration.toml
    lce plan my_face.stl --calibration calibration.toml --out out/plan

**The strips below are synthetic**: a known map, 5 % of scatter from a seeded generator, and one
strip that was measured wrong. So it can be seen whether the fit finds the map, and the strip.
"""

import csv
from pathlib import Path

import numpy as np

from planner.calibration import calibration_toml, fit_calibration, load_calibration, read_strips
from planner.plan import plan
from scenes.case import load_case
from scenes.pictures import draw_calibration, draw_plan

out = Path("out/calibrating_from_strips")
out.mkdir(parents=True, exist_ok=True)

# %%
# The file: one row a strip. Radii are those of the strip as it lies there, whatever its width;
# ``side`` says which half of the layers was scratched.

truth = load_calibration()
rng = np.random.default_rng(7)
loads_g, speeds_mm_s = (0.5, 1.0, 2.0, 4.0, 6.5), (0.5, 0.8, 1.3, 2.0)
rows = [
    (load, speed, float(truth.radius_mm(load, speed) * np.exp(rng.normal(0.0, 0.05))), "bottom", 30.0, 1)
    for load in loads_g
    for speed in speeds_mm_s
]
rows[6] = (*rows[6][:2], 1.6 * rows[6][2], *rows[6][3:])
with (out / "strips.csv").open("w", newline="", encoding="utf-8") as file:
    table = csv.writer(file)
    table.writerow(("load_g", "speed_mm_s", "radius_mm", "side", "width_mm", "repeat"))
    table.writerows(rows)

# %%
# Read and fit. A file that is wrong is refused with every reason at once: missing columns, units,
# too few loads.

fit = fit_calibration(
    read_strips(out / "strips.csv"), name="synthetic", provenance={"method": "synthetic: placeholder and 5 % scatter"}
)
for note in fit.notes:
    print(note)
for outlier in fit.outliers:
    print(f"outlier: {outlier.sentence}")
for key in ("samples", "scatter", "left_out_error", "band"):
    print(f"{key}: {fit.calibration.record.provenance[key]}")
draw_calibration(out / "calibration.png", fit)

# %%
# The band is for the whole map at once, at 99 %. Here the truth is known: it lies inside.

model, uncertainty = fit.calibration.record.model, fit.calibration.record.uncertainty
load, speed = np.meshgrid(model.load_g, model.speed_mm_s, indexing="ij")
off = np.abs(np.log(truth.radius_mm(load, speed) / model.radius_mm))
inside = bool((off <= uncertainty.band_log_radius).all())
print(f"largest error of the map {off.max():.1%}; inside its band: {inside}")

# %%
# Keep it, and plan with it: the plan names its calibration, and ``lce predict`` says how far the
# score is open because of it (``score_band``).

(out / "calibration.toml").write_text(calibration_toml(fit.calibration.record), encoding="utf-8")
measured = load_calibration(out / "calibration.toml")
target = load_case("oblate_dome").make_target()
for calibration in (truth, measured):
    made = plan(target, calibration=calibration, seed=0)
    stroke = made.program.layers[0].passes[0]
    print(
        f"{calibration.record.name}: first pass with {stroke.load_g[0]:.2f} g, "
        f"{made.clamped_wide_share:.0%} of the points bend wider than the map reaches"
    )
draw_plan(out / "plan.png", made.program)
