"""
From an as-run log to the real part
===================================

A film came out flatter than planned. Was it the machine? The log of its run says what was really
scratched, and the twin heats that film instead of the planned one. With the command line::

    lce predict out/run --out out/as-run-hot
    lce score scan.obj --target out/plan/target.npz --out out/score

**The machine and the scan below are simulated**: the post's guide rubs, so that 0.2 g of each
load never reach the film, and the part is seen by a scanner that errs by a tenth of a millimetre.
"""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np

from planner.plan import plan
from planner.program.as_run import AS_RUN_FILE
from planner.program.as_run_film import load_as_run
from rig.executor.session import run_session
from rig.machine_file import load_rig
from scenes.case import load_case
from scenes.pictures import draw_error_map, draw_side_by_side
from scenes.sources import as_it_was_run
from twin.film import FilmOptions
from twin.predict import PredictOptions, predict
from twin.scan import Scanner
from twin.score import score_surface

out = Path("out/from_an_as_run_log")
shutil.rmtree(out, ignore_errors=True)
out.mkdir(parents=True)

# %%
# The run, on a machine whose guide rubs.

target = load_case("oblate_dome").make_target()
program = plan(target, seed=0).program
rig = load_rig()
rubbing = rig.file.simulated.model_copy(update={"post_friction_g": 0.2})
run_session(program, replace(rig, file=rig.file.model_copy(update={"simulated": rubbing})), out / "run")

# %%
# The log gives the film as it was made: the passes with what the post really pressed with, and
# how long each waited for its cure.

film = load_as_run(out / "run" / AS_RUN_FILE)
for note in film.notes:
    print(note)
for layer, strength in zip(film.program.layers, film.pass_strength, strict=True):
    if strength:
        print(
            f"layer {layer.index + 1}: {np.mean(strength):.0%} of the contraction that the least calibrated load gives"
        )

# %%
# Heat both films alike.

options = PredictOptions(film=FilmOptions(mesh_mm=1.0))
planned = predict(film.planned, options)
made = predict(film.program, replace(options, film=as_it_was_run(options.film, film)))
for name, shape in (("as planned", planned), ("as run", made)):
    score = score_surface(shape.top_mm, shape.film.triangles, target).score
    print(f"{name}: SSIM {score.ssim_eq4:.2f}, RMS {score.rms_mm:.2f} mm, {score.depth_mm:.1f} mm deep")
draw_side_by_side(
    out / "shapes.png",
    [planned.top_mm, made.top_mm],
    planned.film.triangles,
    ["as planned", "as run"],
    title="What the run made of the plan",
)

# %%
# Now the scan of the part, here of the film as run. A scan has its own frame and no mesh of ours:
# it is registered first. If it scores as the as-run prediction does, the machine explains the
# part; if not, look at calibration and material.

scanner = Scanner(bias_rms_mm=0.1, noise_rms_mm=0.03)
scan = scanner.scan(made.top_mm, made.film.triangles, np.random.default_rng(0))
scored = score_surface(scan.vertices_mm, scan.triangles, target, coarse=True)
score = scored.score
print(f"scanned: SSIM {score.ssim_eq4:.2f}, RMS {score.rms_mm:.2f} mm, {score.depth_mm:.1f} mm deep")
draw_error_map(
    out / "error.png",
    scored.vertices_mm,
    scored.triangles,
    scored.error_mm,
    rms_mm=score.rms_mm,
    hausdorff_mm=score.hausdorff_mm,
)
