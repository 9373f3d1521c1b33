"""
A dome and a saddle from one target
===================================

The same flat dome is planned by both methods of the paper. Scratched across the incline it
becomes a dome; scratched along the largest curvature it becomes a saddle, as in the paper's Fig.
3. The twin finds both by itself: nothing in it knows which one is meant.
"""

# sphinx_gallery_thumbnail_number = 2
from pathlib import Path

from planner.plan import plan
from scenes.case import load_case
from scenes.pictures import draw_hot_shape, draw_plan, draw_target
from twin.bending import principal_curvatures_per_mm
from twin.film import FilmOptions
from twin.predict import PredictOptions, predict

out = Path("out/dome_and_saddle")
out.mkdir(parents=True, exist_ok=True)

# %%
# The target: the top of an ellipsoid, 21 mm wide and 3.4 mm deep. ``lce scenes`` lists what else is
# built in.

target = load_case("oblate_dome").make_target()
draw_target(out / "target.png", target)

# %%
# Two plans. A plan is a *Program*: every layer with every pass of the scratch post, its load and
# its speeds. Only the two bottom layers are scratched here, since the target is convex
# everywhere.

methods = ("perpendicular", "maximum")
plans = {method: plan(target, method=method, seed=0) for method in methods}
for method, made in plans.items():
    draw_plan(out / f"plan_{method}.png", made.program)

# %%
# Heat both films from flat to 150 C on the hot plate, under their own weight. A mesh of 1 mm is
# coarse and fast; the default is 0.6 mm.

options = PredictOptions(film=FilmOptions(mesh_mm=1.0))
shapes = {method: predict(made.program, options) for method, made in plans.items()}
for method, shape in shapes.items():
    small, large = principal_curvatures_per_mm(shape.film, shape.hot_mm)
    kind = "dome" if small * large > 0 else "saddle"
    print(f"{method}: curvatures {small:+.3f} and {large:+.3f} /mm, a {kind}")

# %%
# Curvature is positive where the film is convex seen from above: two of one sign are a dome, two
# of different signs a saddle.

for method, shape in shapes.items():
    title = f"{method.capitalize()}, 150 C"
    draw_hot_shape(out / f"hot_{method}.png", shape.top_mm, shape.film.triangles, title=title)
