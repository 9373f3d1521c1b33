import numpy as np
import pytest

from planner.errors import InputError
from planner.target import Surface
from scenes.case import list_cases, load_case
from scenes.targets import ellipsoid_dome, face, ridge, saddle, sphere_cap, strip, two_bump

FACE = face()


def heights(target, *points):
    return Surface(target).height(np.array(points, dtype=float))


def test_the_oblate_dome_is_the_ellipsoid_of_its_formula():
    target = ellipsoid_dome(radius_mm=12, height_mm=6, cut=0.9)
    assert target.size_mm == pytest.approx((21.6, 21.6), abs=0.25)
    top, side = heights(target, (0, 0), (6, 0))
    assert top - side == pytest.approx(6 * (1 - np.sqrt(0.75)), abs=0.01)


def test_the_sphere_cap_has_its_radius():
    top, side = heights(sphere_cap(radius_mm=20, edge_radius_mm=14), (0, 0), (0, 10))
    assert top - side == pytest.approx(20 - np.sqrt(300), abs=0.01)


def test_the_saddle_falls_along_x_and_rises_along_y():
    middle, x, y = heights(saddle(radius_mm=12, edge_radius_mm=13), (0, 0), (6, 0), (0, 6))
    assert middle - x == pytest.approx(1.5, abs=0.01)
    assert y - middle == pytest.approx(1.5, abs=0.01)


def test_the_ridge_is_a_cylinder_with_low_ends():
    target = ridge(radius_mm=10, width_mm=17, length_mm=40, end_mm=12)
    top, side, end = heights(target, (0, 0), (5, 0), (0, 19))
    assert top - side == pytest.approx(10 - np.sqrt(75), abs=0.01)
    assert end < 0.35 * top


def test_the_two_bumps_are_convex_on_the_left_and_concave_on_the_right():
    left, middle, right = heights(
        two_bump(width_mm=50, height_mm=30, bump_mm=5, spread_mm=7), (-11, 0), (0, 0), (11, 0)
    )
    assert left - middle == pytest.approx(middle - right, abs=0.02)
    assert left - middle > 4.5


def test_a_strip_is_a_patch_of_its_cylinder():
    target = strip(length_mm=20, width_mm=30, radius_mm=14.4)
    assert not target.notes
    assert target.size_mm == pytest.approx((2 * 14.4 * np.sin(20 / 28.8), 30), abs=0.1)
    top, side = heights(target, (0, 0), (5, 3))
    assert top - side == pytest.approx(14.4 - np.sqrt(14.4**2 - 25), abs=0.01)


def test_a_strip_that_curls_is_cut_with_a_note():
    target = strip(length_mm=20, width_mm=30, radius_mm=1.8)
    assert "318 degrees" in target.notes[0]
    assert target.size_mm[0] == pytest.approx(2 * 1.8 * np.sin(np.deg2rad(65)), abs=0.1)


def test_the_face_has_the_size_and_depth_of_the_paper():
    assert FACE.size_mm == pytest.approx((40, 60), abs=0.5)
    assert 15 < FACE.depth_mm < 19
    assert face(width_mm=20, height_mm=30).depth_mm == pytest.approx(FACE.depth_mm / 2, rel=0.02)


def test_the_face_is_upright_symmetric_and_has_its_features():
    surface = Surface(FACE)
    y = np.arange(-28, 28, 0.25)
    profile = surface.height(np.column_stack([np.zeros_like(y), y]))
    nose = y[np.nanargmax(profile)]
    assert -3 < nose < 2

    def relief(*points):
        return surface.height(np.array(points, dtype=float))

    brow, eye, socket, cheek = relief((8, 14.5), (8.2, 7.6), (4.5, 7.5), (10.8, -1.2))
    assert brow > eye > socket - 0.5
    assert cheek > eye
    upper, groove, lower, under, chin = relief((0, -10), (0, -12.6), (0, -15.2), (0, -18.8), (0, -23))
    assert upper > groove
    assert lower > groove
    assert lower > under
    assert chin > under - 0.5
    xy = np.stack(np.meshgrid(np.arange(0, 15, 1.0), np.arange(-20, 20, 1.0)), axis=-1)
    np.testing.assert_allclose(surface.height(xy), surface.height(xy * [-1, 1]), atol=1e-3)


def test_the_face_has_no_creases():
    step = FACE.x_mm[1] - FACE.x_mm[0]
    gy, gx = np.gradient(FACE.z_mm, step)
    slope = np.hypot(gx, gy)
    assert np.rad2deg(np.arctan(np.nanmax(slope))) < 66
    gyy, gxy = np.gradient(gy, step)
    gxx = np.gradient(gx, step, axis=1)
    mean = ((1 + gx**2) * gyy - 2 * gx * gy * gxy + (1 + gy**2) * gxx) / (2 * (1 + slope**2) ** 1.5)
    gauss = (gxx * gyy - gxy**2) / (1 + slope**2) ** 2
    largest = np.abs(mean) + np.sqrt(np.maximum(mean**2 - gauss, 0))
    assert 1 / np.nanmax(largest) > 0.9
    assert 1 / np.nanquantile(largest, 0.95) > 2.0


def test_every_built_in_case_makes_its_target():
    cases = list_cases()
    assert {
        "face", "oblate_dome", "prolate_dome", "sphere_cap", "saddle", "ridge", "two_bump",
        "strip_tight", "strip_medium", "strip_gentle",
    } == {case.name for case in cases}  # fmt: skip
    for case in cases:
        assert load_case(case.name) == case
        assert case.make_target().name == case.name
        assert "\n" not in case.description


def case_file(tmp_path, text):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    return path


GOOD = """
name = "mine"
description = "a strip"
[target]
kind = "strip"
length_mm = 20.0
width_mm = 30.0
contraction = 0.10
"""


def test_a_case_file_and_the_radius_of_a_contraction(tmp_path):
    case = load_case(case_file(tmp_path, GOOD))
    assert case.plan.method == "perpendicular"
    # The wide-strip table: 10 % bends two of four layers of 0.2 mm to 6.96 mm.
    assert case.target.bending_radius_mm == pytest.approx(6.96, rel=0.005)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (("length_mm", "lenght_mm"), "did you mean length_mm?"),
        (("[target]", "[plan]\nmethd = 'maximum'\n[target]"), "did you mean method?"),
        (("[target]", "descripton = 'x'\n[target]"), "did you mean description?"),
        (("contraction = 0.10", "contraction = 0.1\nradius_mm = 3"), "exactly one of"),
        (("length_mm = 20.0", "length_mm = -1"), "length_mm"),
        (("length_mm = 20.0", "length_mm = nan"), "length_mm"),
        (('"strip"', '"stripe"'), "strip"),
        (("[target]", "[target"), "TOML"),
    ],
)
def test_a_wrong_case_file_is_told_where_and_what(tmp_path, change, expected):
    with pytest.raises(InputError) as caught:
        load_case(case_file(tmp_path, GOOD.replace(*change)))
    assert expected in str(caught.value)
    assert "mine.toml" in str(caught.value)


def test_all_problems_of_a_case_are_told_at_once(tmp_path):
    text = GOOD.replace("length_mm = 20.0", "length_mm = -1\nheigth_mm = 2").replace('"mine"', '""')
    with pytest.raises(InputError) as caught:
        load_case(case_file(tmp_path, text))
    assert len(caught.value.problems) == 3


def test_an_unknown_name_gets_the_nearest_one(tmp_path):
    with pytest.raises(InputError, match="did you mean oblate_dome"):
        load_case("oblat_dome")
    with pytest.raises(InputError, match="no such case file"):
        load_case(tmp_path / "absent.toml")
