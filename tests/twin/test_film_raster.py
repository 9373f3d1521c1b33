"""Passes painted into a layer: where, which way, how strongly, and who overwrites whom."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.calibration import load_calibration
from planner.program import Pass
from twin.film import AlignmentRaster, paint_passes
from twin.film.raster import PIXEL_MM

CALIBRATION = load_calibration()
BOUNDS = (np.array([-8.0, -8.0]), np.array([8.0, 8.0]))
WIDTH_MM = 0.8
STRONG = float(CALIBRATION.contraction(6.5, 0.5))
WEAK = float(CALIBRATION.contraction(0.5, 2.0))


def stroke(*points, load_g=(6.5,), speed_mm_s=0.5) -> Pass:
    return Pass(
        points_mm=tuple((float(x), float(y)) for x, y in points),
        speed_mm_s=tuple(np.broadcast_to(np.asarray(speed_mm_s, dtype=float), len(points) - 1).tolist()),
        load_g=tuple(float(load) for load in load_g),
        side="convex",
    )


def paint(*passes, blur_mm=0.0, bounds=BOUNDS) -> AlignmentRaster:
    return paint_passes(passes, CALIBRATION, bounds, line_width_mm=WIDTH_MM, edge_blur_mm=blur_mm)


def pixels(raster: AlignmentRaster) -> tuple[np.ndarray, np.ndarray]:
    """x and y of the pixel centres [mm], each shape [rows, columns]."""
    rows, columns = np.indices(raster.q.shape[1:])
    return raster.origin_mm[0] + PIXEL_MM * columns, raster.origin_mm[1] + PIXEL_MM * rows


def strength(raster: AlignmentRaster) -> np.ndarray:
    return np.hypot(*raster.q)


def director_deg(raster: AlignmentRaster, x: float, y: float) -> float:
    """Director at a point, in [0, 180) [deg]."""
    q = raster.sample(np.array([x, y]))
    return float(np.rad2deg(0.5 * np.arctan2(q[1], q[0])) % 180.0)


def apart_deg(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Smallest angle between directors [deg]."""
    return np.abs((one - other + 90.0) % 180.0 - 90.0)


def distance_to(a, b, x, y) -> np.ndarray:
    """Distance of points from the segment a-b, point by point."""
    a, along = np.asarray(a, dtype=float), np.subtract(b, a, dtype=float)
    share = np.clip(((x - a[0]) * along[0] + (y - a[1]) * along[1]) / (along @ along), 0.0, 1.0)
    return np.hypot(x - a[0] - share * along[0], y - a[1] - share * along[1])


def test_straight_pass_paints_a_stadium():
    raster = paint(stroke((-3.0, 0.03), (3.0, 0.03)))
    x, y = pixels(raster)
    painted = strength(raster) > 0
    np.testing.assert_array_equal(painted, distance_to((-3, 0.03), (3, 0.03), x, y) <= 0.4 + 1e-6)
    assert painted.any(axis=1).sum() * PIXEL_MM == pytest.approx(0.8, abs=1.01 * PIXEL_MM)
    assert painted.any(axis=0).sum() * PIXEL_MM == pytest.approx(6.8, abs=1.01 * PIXEL_MM)
    assert painted.sum() * PIXEL_MM**2 == pytest.approx(6 * 0.8 + np.pi * 0.4**2, rel=0.02)
    # the ends are round: the corners of the line's bounding box stay free
    corner = (np.abs(y - 0.03) > 0.32) & (np.abs(x) > 3.28)
    assert not painted[corner].any()


@pytest.mark.parametrize("angle_deg", [0.0, 30.0, 45.0, 90.0, 135.0, 200.0, 330.0])
def test_alignment_is_along_the_stroke_and_the_way_back_is_the_same(angle_deg):
    end = 4.0 * np.array([np.cos(np.deg2rad(angle_deg)), np.sin(np.deg2rad(angle_deg))])
    there, back = paint(stroke(-end, end)), paint(stroke(end, -end))
    double = 2.0 * np.deg2rad(angle_deg)
    painted = strength(there) > 0
    np.testing.assert_allclose(there.q[0][painted], STRONG * np.cos(double), atol=1e-12)
    np.testing.assert_allclose(there.q[1][painted], STRONG * np.sin(double), atol=1e-12)
    np.testing.assert_allclose(back.q, there.q, atol=1e-12)


def test_contraction_follows_load_and_speed():
    raster = paint(stroke((-4, 2), (4, 2)), stroke((-4, -2), (4, -2), load_g=(0.5,), speed_mm_s=2.0))
    assert np.hypot(*raster.sample(np.array([0.0, 2.0]))) == pytest.approx(STRONG)
    assert np.hypot(*raster.sample(np.array([0.0, -2.0]))) == pytest.approx(WEAK)
    assert WEAK < 0.3 * STRONG


def test_speed_may_change_along_a_pass():
    raster = paint(stroke((-4, 0), (0, 0), (4, 0), speed_mm_s=(0.5, 2.0)))
    assert np.hypot(*raster.sample(np.array([-2.0, 0.0]))) == pytest.approx(STRONG)
    assert np.hypot(*raster.sample(np.array([2.0, 0.0]))) == pytest.approx(float(CALIBRATION.contraction(6.5, 2.0)))


def test_loads_given_at_the_points_are_interpolated_along_the_pass():
    raster = paint(stroke((-6, 0), (6, 0), load_g=(0.5, 6.5)))
    x = np.linspace(-5.5, 5.5, 111)
    found = np.hypot(*raster.sample(np.column_stack((x, np.zeros_like(x)))).T)
    wanted = CALIBRATION.contraction(0.5 + 6.0 * (x + 6.0) / 12.0, 0.5)
    # pieces as long as the line is wide: half a piece of the load's rise
    np.testing.assert_allclose(found, wanted, atol=0.5 * WIDTH_MM * np.gradient(wanted, x).max() + 1e-9)
    assert np.all(np.diff(found) >= -1e-12)


def test_the_later_pass_overwrites():
    along_x, along_y = stroke((-4, 0), (4, 0)), stroke((0, -4), (0, 4))
    assert director_deg(paint(along_x, along_y), 0.0, 0.0) == pytest.approx(90.0)
    assert apart_deg(director_deg(paint(along_y, along_x), 0.0, 0.0), 0.0) == pytest.approx(0.0, abs=1e-9)
    raster = paint(along_x, along_y)
    assert apart_deg(director_deg(raster, 2.0, 0.0), 0.0) == pytest.approx(0.0, abs=1e-9)


def test_segments_of_a_bend_share_by_distance():
    first, corner, last = (-4.0, 0.013), (0.007, 0.013), (2.5, 3.1)
    raster = paint(stroke(first, corner, last))
    x, y = pixels(raster)
    to_first, to_last = distance_to(first, corner, x, y), distance_to(corner, last, x, y)
    angle = np.rad2deg(0.5 * np.arctan2(raster.q[1], raster.q[0]))
    slope = np.rad2deg(np.arctan2(last[1] - corner[1], last[0] - corner[0]))
    nearer_first = (to_first < to_last - 1e-6) & (to_first < 0.4)
    nearer_last = (to_last < to_first - 1e-6) & (to_last < 0.4)
    np.testing.assert_allclose(apart_deg(angle[nearer_first], 0.0), 0.0, atol=1e-6)
    np.testing.assert_allclose(apart_deg(angle[nearer_last], slope), 0.0, atol=1e-6)
    assert min(nearer_first.sum(), nearer_last.sum()) > 200


def test_a_pass_that_crosses_itself_counts_the_second_visit():
    loop = stroke((-4, 0), (3, 0), (3, 3), (0, 3), (0, -4))
    assert director_deg(paint(loop), 0.0, 0.0) == pytest.approx(90.0)
    back = stroke((0, -4), (0, 3), (3, 3), (3, 0), (-4, 0))
    assert apart_deg(director_deg(paint(back), 0.0, 0.0), 0.0) == pytest.approx(0.0, abs=1e-9)


def test_closed_ring_is_azimuthal_all_round():
    angle = np.linspace(0.0, 2.0 * np.pi, 73)
    raster = paint(stroke(*np.column_stack((4.0 * np.cos(angle), 4.0 * np.sin(angle)))))
    x, y = pixels(raster)
    painted = strength(raster) > 0
    assert painted.sum() * PIXEL_MM**2 == pytest.approx(2.0 * np.pi * 4.0 * WIDTH_MM, rel=0.01)
    assert np.all(painted[np.abs(np.hypot(x, y) - 4.0) < 0.39])
    wanted = np.rad2deg(np.arctan2(y, x)) + 90.0
    found = np.rad2deg(0.5 * np.arctan2(raster.q[1], raster.q[0]))
    # a segment spans 5 degrees, so it lies within 2.5 of the circle; the seam's round end reaches 0.4 mm on
    seam = (x > 0) & (np.abs(y) < 0.5)
    assert apart_deg(found, wanted)[painted & ~seam].max() < 2.6
    assert apart_deg(found, wanted)[painted & seam].max() < 10.0


@pytest.mark.parametrize("blur_mm", [0.05, 0.1, 0.3])
def test_edge_blur_softens_and_conserves_the_integral(blur_mm):
    passes = (stroke((-3, -1), (2, 2)), stroke((-2, 2), (3, 1), load_g=(2.0,)))
    sharp, soft = paint(*passes), paint(*passes, blur_mm=blur_mm)
    np.testing.assert_allclose(soft.q.sum(axis=(1, 2)), sharp.q.sum(axis=(1, 2)), rtol=1e-9)
    assert np.abs(np.diff(soft.q, axis=1)).max() < np.abs(np.diff(sharp.q, axis=1)).max()
    assert strength(soft).max() <= strength(sharp).max() + 1e-12


def test_blurred_edge_is_half_as_strong_where_the_line_ends():
    """Far from the ends the profile across is a difference of two error functions."""
    raster = paint(stroke((-7, 0.05), (7, 0.05)), blur_mm=0.1)
    edge = np.hypot(*raster.sample(np.array([0.0, 0.45])))
    assert edge == pytest.approx(0.5 * STRONG, rel=0.05)
    assert np.hypot(*raster.sample(np.array([0.0, 0.05]))) == pytest.approx(STRONG, rel=1e-3)
    assert np.hypot(*raster.sample(np.array([0.0, 1.05]))) < 1e-3 * STRONG


def test_layer_without_passes_is_polydomain():
    raster = paint(blur_mm=0.1)
    assert raster.q.shape == (2, 161, 161)
    assert not raster.q.any()


def test_samples_are_bilinear_and_zero_beyond_the_grid():
    rows, columns = np.indices((6, 9))
    raster = AlignmentRaster(origin_mm=np.array([1.0, -2.0]), q=np.stack((2.0 * columns + rows, columns * rows)) * 1.0)
    x, y = 1.0 + PIXEL_MM * 3.25, -2.0 + PIXEL_MM * 2.5
    np.testing.assert_allclose(raster.sample(np.array([x, y])), (2.0 * 3.25 + 2.5, 3.25 * 2.5))
    far = np.array([[[0.0, 0.0], [1.0 + PIXEL_MM * 10.5, -1.8]]])
    np.testing.assert_array_equal(raster.sample(far), np.zeros((1, 2, 2)))


def test_passes_may_leave_the_painted_region():
    raster = paint(stroke((-20, 7.9), (20, 7.9)), stroke((30, 0), (40, 0)))
    assert strength(raster)[:, 80][-5:] == pytest.approx(STRONG)
    assert not strength(raster)[:150].any()


@settings(max_examples=60, deadline=None)
@given(
    angle=st.floats(0.0, np.pi),
    x=st.floats(-0.5, 0.5),
    y=st.floats(-0.5, 0.5),
    turned=st.booleans(),
    pieces=st.integers(1, 5),
)
def test_touching_passes_leave_no_gap(angle, x, y, turned, pieces):
    """Two passes a line width apart, wherever and however they lie: every pixel between them is aligned."""
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    offset = np.array([x, y])
    at = np.linspace(-4.0, 4.0, pieces + 1)[:, None] * along
    first = offset + 0.5 * WIDTH_MM * across + at
    second = offset - 0.5 * WIDTH_MM * across + (-at if turned else at)
    raster = paint(stroke(*first), stroke(*second), bounds=(np.array([-5.0, -5.0]), np.array([5.0, 5.0])))
    px, py = pixels(raster)
    u = (px - offset[0]) * along[0] + (py - offset[1]) * along[1]
    v = (px - offset[0]) * across[0] + (py - offset[1]) * across[1]
    between = (np.abs(u) <= 4.0) & (np.abs(v) <= WIDTH_MM)
    np.testing.assert_allclose(strength(raster)[between], STRONG, rtol=1e-12)
