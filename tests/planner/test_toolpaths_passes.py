from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.calibration import load_calibration
from planner.program import Pass
from planner.toolpaths import TracedPass, coverage, load_levels, order_passes, set_passes, travel_mm
from planner.toolpaths.order import nearest_next, reverse, two_opt


def line(x: float, y: float, *, length: float = 2.0, load: float = 1.0) -> Pass:
    return Pass(points_mm=((x, y), (x + length, y)), speed_mm_s=(1.0,), load_g=(load,), side="convex")


def straight(count: int) -> TracedPass:
    points = np.stack([0.8 * np.arange(count), np.zeros(count)], axis=1)
    return TracedPass(points_mm=points, curvature_per_mm=np.full(count, 0.2))


def test_load_levels_reach_both_ends_and_their_speeds_overlap() -> None:
    calibration = load_calibration()
    levels = load_levels(calibration)
    assert levels[0] == 0.5
    assert levels[-1] == 6.5
    ranges = [calibration.radius_range_mm(float(load)) for load in levels]
    for lighter, heavier in pairwise(ranges):
        assert lighter[0] < heavier[1]


@settings(max_examples=20, deadline=None)
@given(st.floats(1.8, 14.4), st.integers(2, 12))
def test_a_constant_radius_is_given_exactly(radius: float, count: int) -> None:
    result = set_passes([straight(count)], [np.full(count - 1, radius)], load_calibration(), "convex")
    assert result.given_radius_mm == pytest.approx(radius, rel=0.006)
    (stroke,) = result.passes
    calibration = load_calibration()
    promised = calibration.radius_mm(stroke.load_g[0], np.array(stroke.speed_mm_s))
    np.testing.assert_allclose(promised, result.given_radius_mm, rtol=1e-3)


def test_of_equally_good_loads_the_fastest_is_taken() -> None:
    result = set_passes([straight(5)], [np.full(4, 3.2)], load_calibration(), "concave")
    (stroke,) = result.passes
    # 3.2 mm can be had at 6.5 g and 2 mm/s, at 2.5 g and 1 mm/s, at 1.5 g and 0.5 mm/s.
    assert stroke.load_g == (6.5,)
    assert min(stroke.speed_mm_s) > 1.8
    assert stroke.side == "concave"


def test_the_speed_follows_the_radius_along_a_pass() -> None:
    radius = np.array([4.5, 5.0, 6.0, 7.0])
    result = set_passes([straight(5)], [radius], load_calibration(), "convex")
    np.testing.assert_allclose(result.given_radius_mm, radius, rtol=0.01)
    assert np.all(np.diff(result.passes[0].speed_mm_s) > 0)


def test_radii_beyond_the_range_are_taken_at_its_ends() -> None:
    radius = [np.array([0.5, 1.0]), np.array([50.0, np.inf])]
    result = set_passes([straight(3), straight(3)], radius, load_calibration(), "convex")
    np.testing.assert_allclose(result.wanted_radius_mm, [1.8, 1.8, 14.4, 14.4])
    assert result.passes[0].load_g == (6.5,)
    assert result.passes[0].speed_mm_s == (0.5, 0.5)
    assert result.passes[1].load_g == (0.5,)
    assert result.passes[1].speed_mm_s == (2.0, 2.0)
    assert set_passes([], [], load_calibration(), "convex").passes == ()


def test_a_hatch_is_scratched_back_and_forth() -> None:
    hatch = [line(0, y) for y in (3, 1, 0, 2)]
    ordered = order_passes(hatch)
    # From the line at 3 down to 0: three moves to the next line, always on the near side.
    assert travel_mm(ordered) == pytest.approx(3)
    assert travel_mm(hatch) > 7
    assert sorted(stroke.points_mm[0][1] for stroke in ordered) == [0, 1, 2, 3]


def test_each_load_is_set_once_from_light_to_heavy() -> None:
    passes = [line(i, i % 3, load=load) for i, load in enumerate([3.0, 1.0, 2.0, 1.0, 3.0])]
    assert [stroke.load_g[0] for stroke in order_passes(passes)] == [1.0, 1.0, 2.0, 3.0, 3.0]
    assert order_passes([]) == ()


def test_a_reversed_pass_keeps_its_speeds_in_place() -> None:
    stroke = Pass(points_mm=((0, 0), (1, 0), (1, 2)), speed_mm_s=(1.0, 2.0), load_g=(1.0, 2.0, 3.0), side="convex")
    back = reverse(stroke)
    assert back.points_mm[0] == (1, 2)
    assert back.speed_mm_s == (2.0, 1.0)
    assert back.load_g == (3.0, 2.0, 1.0)
    assert reverse(back) == stroke
    assert back.scratch_s == stroke.scratch_s


@settings(max_examples=25, deadline=None)
@given(st.integers(1, 25), st.integers(0, 2**32 - 1))
def test_ordering_loses_nothing_and_two_opt_never_lengthens(count: int, seed: int) -> None:
    ends = np.random.default_rng(seed).uniform(0, 20, (count, 2, 2))

    def travel(sequence: np.ndarray, flipped: np.ndarray) -> float:
        entry, leave = ends[sequence, flipped.astype(int)], ends[sequence, 1 - flipped.astype(int)]
        return float(np.linalg.norm(entry[1:] - leave[:-1], axis=1).sum())

    greedy = nearest_next(ends)
    better = two_opt(ends, *greedy)
    assert sorted(better[0]) == list(range(count))
    assert travel(*better) <= travel(*greedy) + 1e-9


def test_two_opt_uncrosses() -> None:
    ends = np.array([[[x, 0.0], [x, 0.0]] for x in (0.0, 2.0, 1.0, 3.0)])
    sequence, _ = two_opt(ends, np.arange(4), np.zeros(4, dtype=bool))
    np.testing.assert_array_equal(sequence, [0, 2, 1, 3])


def test_coverage_of_two_lines() -> None:
    apart = coverage([line(0, 0), line(0, 5)], 0.8)
    assert apart.overlap == pytest.approx(0, abs=1e-12)
    assert apart.aligned_mm2 == pytest.approx(2 * (2 * 0.8 + np.pi * 0.16), rel=0.02)
    twice = coverage([line(0, 0), line(0, 0)], 0.8)
    assert twice.overlap == pytest.approx(0.5)
    assert coverage([], 0.8).overlap == 0
