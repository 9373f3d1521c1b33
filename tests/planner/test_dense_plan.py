import json
from typing import cast

import numpy as np
import pytest

from planner.errors import InputError
from planner.plan import plan, plan_summary
from planner.target import Target, target_from_heights
from planner.toolpaths import Tracer
from planner.toolpaths.dense import cloud_field, trace_dense


def ball_cap() -> Target:
    axis = np.arange(-12, 12.01, 0.25)
    x, y = np.meshgrid(axis, axis)
    radius = np.hypot(x, y)
    height = np.sqrt(400 - np.minimum(radius, 12) ** 2)
    return target_from_heights(name="cap", x_mm=axis, y_mm=axis, z_mm=np.where(radius <= 12.01, height, np.nan))


def cloud(width: float, height: float) -> np.ndarray:
    axes = [np.arange(0, side + 1e-9, 0.1) for side in (width, height)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)


def test_a_clouds_field_has_its_directions_and_ends_at_its_border() -> None:
    points = cloud(10, 6)
    field = cloud_field(points, np.full(len(points), 2.0), 0.8)
    q = field.at(np.array([(5.0, 3.0), (0.0, 3.0), (-1.5, 3.0), (50.0, 50.0)])).q
    np.testing.assert_allclose(q[0], (np.cos(4.0), np.sin(4.0)), atol=1e-3)
    strength = np.linalg.norm(q, axis=1)
    assert strength[1] == pytest.approx(0.7, abs=0.1)
    assert np.all(strength[2:] < 0.01)


def test_a_cloud_becomes_parallel_passes_with_its_curvature() -> None:
    points = cloud(10, 6)
    curvature = 0.1 + 0.01 * points[:, 0]
    traced = trace_dense(points, np.zeros(len(points)), curvature, np.random.default_rng(0))
    # A line beside the border lies up to half its width off it.
    assert traced.covered.mean() > 0.94
    assert 7 <= len(traced.passes) <= 10
    for stroke in traced.passes:
        inner = (stroke.points_mm[:, 0] > 0.5) & (stroke.points_mm[:, 0] < 9.5)
        expected = 0.1 + 0.01 * stroke.points_mm[inner, 0]
        np.testing.assert_allclose(stroke.curvature_per_mm[inner], expected, atol=0.002)
    nothing = trace_dense(np.empty((0, 2)), np.empty(0), np.empty(0), np.random.default_rng(0))
    assert nothing.passes == ()


def test_a_dense_plan_tiles_what_the_greedy_one_overlaps() -> None:
    greedy, dense = (plan(ball_cap(), tracer=cast(Tracer, tracer)) for tracer in ("greedy", "dense"))
    paper, ours = greedy.sides["convex"].tiling, dense.sides["convex"].tiling
    assert ours.coverage >= max(0.97, paper.coverage)
    assert ours.overlap <= 0.03 < paper.overlap
    assert ours.passes < paper.passes
    assert dense.sides["concave"].passes == 0
    assert dense.program.inputs.settings["tracer"] == "dense"
    assert json.loads(json.dumps(plan_summary(dense)))["sides"]["convex"]["tiling"]["overlap"] == ours.overlap
    assert dense.problems == ()
    again = plan(ball_cap(), tracer="dense")
    assert again.program.digest == dense.program.digest


def test_an_unknown_tracer_is_told() -> None:
    with pytest.raises(InputError, match="greedy and dense"):
        plan(ball_cap(), tracer=cast(Tracer, "spiral"))
