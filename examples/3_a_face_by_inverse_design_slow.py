"""
A face by inverse design
========================

The paper's methods scratch two of four layers, along curvature alone. Here all four layers are
chosen through the simulated film: what must each be taught so that the sheet, lying on the hot
plate under its own weight, becomes the face? It takes about three minutes on two cores, which is
why ``make docs`` shows this page without running it and ``make docs-slow`` runs it. With the
command line::

    lce plan face --method inverse --out out/inverse

.. image:: /pictures/face-inverse.png
   :alt: target, predicted shape and error of the inverse design
"""

# sphinx_gallery_thumbnail_path = 'pictures/face-inverse.png'
from pathlib import Path

from scenes.case import load_case
from scenes.pictures import draw_design, draw_plan, draw_search
from scenes.prediction import PAPER_SSIM
from twin.inverse import design_inverse

out = Path("out/face_by_inverse_design")
out.mkdir(parents=True, exist_ok=True)

# %%
# Search. Each step of it can be watched; a film whose passes would snap elsewhere on their way
# from flat is designed again.

target = load_case("face").make_target()
made = design_inverse(
    target,
    watch=lambda moment: print(f"{moment.elapsed_s:4.0f} s  {moment.stage}: SSIM {moment.ssim:.3f}"),
)

# %%
# The score is that of the passes, heated from flat: not of the smooth fields that they were
# traced from, and not of the shape that the search ended in.

score = made.score
print(
    f"SSIM {score.ssim_eq4:.3f}, RMS {score.rms_mm:.2f} mm, {score.depth_mm:.1f} of {score.target_depth_mm:.1f} mm deep"
)
print(f"smooth fields without passes: SSIM {made.ideal.ssim_eq4:.3f}")
for limit in made.limits:
    print(f"limit: {limit}")
draw_search(out / "search.png", made.history, score, title="face: inverse design", paper_ssim=PAPER_SSIM)

# %%
# Each layer has passes of its own.

draw_plan(out / "plan.png", made.program)

# %%
# Target, prediction and error in one scale.

draw_design(out / "design.png", target, made.scored)
