import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist

from planner.toolpaths import Tracing, trace_passes


def cloud(width: float, height: float, spacing: float = 0.1) -> np.ndarray:
    x, y = np.meshgrid(np.arange(0, width + 1e-9, spacing), np.arange(0, height + 1e-9, spacing))
    return np.stack([x.ravel(), y.ravel()], axis=1)


def traced(points: np.ndarray, direction: np.ndarray, seed: int = 0, **options: float) -> Tracing:
    curvature = np.linspace(0.1, 0.2, len(points))
    return trace_passes(points, direction, curvature, np.random.default_rng(seed), **options)


def test_a_strip_one_line_wide_is_one_pass() -> None:
    points = cloud(10.0, 0.0)
    tracing = traced(points, np.zeros(len(points)))
    (stroke,) = tracing.passes
    steps = np.linalg.norm(np.diff(stroke.points_mm, axis=0), axis=1)
    assert len(stroke.points_mm) >= 12
    np.testing.assert_allclose(steps[1:-1], 0.8, atol=1e-9)
    # The last step may overshoot the edge by half a line width and come back to it.
    assert np.all(steps >= 0.4 - 1e-9)
    assert tracing.covered.all()


def test_parallel_directions_give_parallel_passes() -> None:
    points = cloud(12.0, 8.0)
    for angle in (0.0, 0.7, np.pi / 2, 3.0):
        tracing = traced(points, np.full(len(points), angle))
        for stroke in tracing.passes:
            # Steps that overshoot the edge snap back along it: only the inner ones must keep the direction.
            inner = np.all((stroke.points_mm > 0.5) & (stroke.points_mm < (11.5, 7.5)), axis=1)
            ahead = np.diff(stroke.points_mm, axis=0)[inner[1:] & inner[:-1]]
            turn = np.abs(np.sin(np.arctan2(ahead[:, 1], ahead[:, 0]) - angle))
            assert np.all(turn < 0.09)


def test_directions_are_modulo_pi() -> None:
    points = cloud(12.0, 4.0)
    rng = np.random.default_rng(1)
    mixed = rng.choice([0.0, np.pi], len(points))
    for first, second in zip(traced(points, np.zeros(len(points))).passes, traced(points, mixed).passes, strict=True):
        np.testing.assert_array_equal(np.sort(first.points_mm, axis=0), np.sort(second.points_mm, axis=0))


def test_rings_close_on_themselves() -> None:
    points = cloud(20.0, 20.0) - 10
    points = points[np.abs(np.hypot(*points.T) - 8) < 0.15]
    (stroke,) = traced(points, np.arctan2(points[:, 1], points[:, 0]) + np.pi / 2).passes
    np.testing.assert_array_equal(stroke.points_mm[0], stroke.points_mm[-1])
    angle = np.unwrap(np.arctan2(stroke.points_mm[:, 1], stroke.points_mm[:, 0]))
    assert abs(angle[-1] - angle[0]) == pytest.approx(2 * np.pi)


@pytest.mark.parametrize(("turn", "together"), [(29.9, True), (30.1, False)])
def test_a_turn_of_more_than_thirty_degrees_ends_a_pass(turn: float, together: bool) -> None:
    points = cloud(10.0, 0.0)
    direction = np.where(points[:, 0] < 5, 0.0, np.radians(turn))
    strokes = traced(points, direction).passes
    crossing = [stroke for stroke in strokes if stroke.points_mm[:, 0].min() < 4 and stroke.points_mm[:, 0].max() > 5.5]
    assert bool(crossing) == together


def test_a_hole_wider_than_a_step_ends_a_pass() -> None:
    points = cloud(20.0, 0.0)
    narrow, wide = (points[np.abs(points[:, 0] - 10) > gap / 2] for gap in (0.7, 2.5))
    assert max(np.ptp(stroke.points_mm[:, 0]) for stroke in traced(narrow, np.zeros(len(narrow))).passes) > 15
    assert max(np.ptp(stroke.points_mm[:, 0]) for stroke in traced(wide, np.zeros(len(wide))).passes) < 10


def test_a_speck_is_too_short_to_scratch() -> None:
    points = cloud(0.3, 0.3)
    tracing = traced(points, np.zeros(len(points)))
    assert tracing.passes == ()
    assert tracing.dropped == 1
    assert not tracing.covered.any()
    assert traced(np.empty((0, 2)), np.empty(0)).passes == ()


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.4, 1.2), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_what_every_tracing_must_do(seed: int, width: float, a: float, b: float) -> None:
    points = cloud(6.0, 5.0)
    direction = a * points[:, 0] + b * points[:, 1]
    tracing = traced(points, direction, seed, line_width_mm=width)
    again = traced(points, direction, seed, line_width_mm=width)
    assert len(tracing.passes) == len(again.passes)
    distance = np.full(len(points), np.inf)
    for stroke in tracing.passes:
        assert len(stroke.points_mm) == len(stroke.curvature_per_mm) >= 2
        assert np.all(np.linalg.norm(np.diff(stroke.points_mm, axis=0), axis=1) > 0)
        # Each point of a path is a point of the cloud.
        assert cdist(stroke.points_mm, points).min(axis=1).max() == 0
        begin, ahead = stroke.points_mm[:-1, None], np.diff(stroke.points_mm, axis=0)[:, None]
        share = np.clip(((points - begin) * ahead).sum(-1) / (ahead**2).sum(-1), 0, 1)[..., None]
        distance = np.minimum(distance, np.linalg.norm(points - begin - share * ahead, axis=-1).min(axis=0))
    # on the contour itself rounding decides
    clear = np.abs(distance - width / 2) > 1e-9
    np.testing.assert_array_equal((distance <= width / 2)[clear], tracing.covered[clear])


def test_a_new_pass_starts_outside_the_earlier_ones() -> None:
    points = cloud(8.0, 6.0)
    tracing = traced(points, np.zeros(len(points)))
    for number, stroke in enumerate(tracing.passes):
        for earlier in tracing.passes[:number]:
            assert cdist(stroke.points_mm, earlier.points_mm).min() > 0.4
