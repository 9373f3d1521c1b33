import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.errors import InputError
from planner.target import Surface, Target, target_from_heights
from planner.target.outline import loop_length, region_outlines, signed_area, signed_distance


def grid(width=20.0, height=30.0, cell=0.25):
    x = np.linspace(-width / 2, width / 2, round(width / cell) + 1)
    y = np.linspace(-height / 2, height / 2, round(height / cell) + 1)
    return x, y, *np.meshgrid(x, y)


def oval_dome(cell=0.25):
    x, y, X, Y = grid(cell=cell)
    z = 8.0 - 0.02 * (X**2 + Y**2)
    z[(X / 10) ** 2 + (Y / 15) ** 2 > 1 + 1e-9] = np.nan
    return x, y, z


def curvature(loop):
    step = np.diff(np.vstack((loop, loop[:2])), axis=0)
    angle = np.unwrap(np.arctan2(step[:, 1], step[:, 0]))
    return np.diff(angle) / np.linalg.norm(step[1:], axis=1)


def test_a_target_is_centred_and_starts_at_zero():
    x, y, z = oval_dome()
    target = target_from_heights("dome", x + 7.0, y - 3.0, z + 100.0, ["a note"])
    low, high = target.bounds_mm
    assert np.allclose(low + high, 0.0, atol=1e-12)
    assert np.nanmin(target.z_mm) == 0.0
    assert target.size_mm == pytest.approx((20.0, 30.0), abs=0.3)
    assert target.notes == ("a note",)
    again = target_from_heights("dome", target.x_mm, target.y_mm, target.z_mm)
    assert again.digest == target.digest
    assert np.allclose(again.outline_mm, target.outline_mm, atol=1e-9)


def test_descending_axes_are_turned():
    x, y, z = oval_dome()
    z[:20] += 1.0
    straight = target_from_heights("dome", x, y, z)
    assert target_from_heights("dome", x[::-1], y, z[:, ::-1]).digest == straight.digest
    assert target_from_heights("dome", x, y[::-1], z[::-1]).digest == straight.digest


@pytest.mark.parametrize("cell", [0.1, 0.25, 0.5])
def test_the_outline_of_an_oval_has_no_grid_teeth(cell):
    x, y, z = oval_dome(cell)
    outline = target_from_heights("dome", x, y, z).outline_mm
    assert signed_area(outline) == pytest.approx(np.pi * 10 * 15, rel=0.02 * cell)
    radius = np.hypot(outline[:, 0] / 10, outline[:, 1] / 15)
    assert np.abs(radius - 1).max() * 10 < 0.6 * cell
    # The staircase of the grid turns by 45 degrees at every step; the oval's own curvature is 0.04 .. 0.15.
    assert np.percentile(curvature(outline), [2, 98]) == pytest.approx([0.04, 0.15], abs=0.12)
    step = loop_length(outline) / len(outline)
    assert 0.2 < step <= 0.26


def test_a_rectangle_keeps_its_edges_and_nearly_its_corners():
    x, y, X, _ = grid()
    target = target_from_heights("ridge", x, y, np.cos(X / 5))
    assert target.size_mm == pytest.approx((20.0, 30.0), abs=1e-9)
    corner = np.linalg.norm(target.outline_mm - [10.0, 15.0], axis=1).min()
    assert corner < 0.25
    assert signed_area(target.outline_mm) == pytest.approx(600.0, rel=3e-3)


@settings(max_examples=15, deadline=None)
@given(angle=st.floats(0.0, 1.5), cell=st.sampled_from([0.2, 0.3]))
def test_a_turned_rectangle_stays_straight(angle, cell):
    axis = np.arange(-12.0, 12.0, cell)
    X, Y = np.meshgrid(axis, axis)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    u, v = np.moveaxis(np.stack((X, Y), axis=-1) @ turn.T, -1, 0)
    outline = region_outlines((np.abs(u) <= 5) & (np.abs(v) <= 8), axis, axis)[0] @ turn.T
    off = np.maximum(np.abs(outline[:, 0]) - 5, np.abs(outline[:, 1]) - 8)
    middle = (np.abs(outline[:, 0]) < 4) | (np.abs(outline[:, 1]) < 7)
    assert np.abs(off[middle]).max() < 1.1 * cell
    assert np.abs(off).max() < 1.6 * cell


def test_signed_distance_to_a_square():
    side = np.linspace(0.0, 1.0, 50, endpoint=False)
    square = np.vstack(
        [
            np.column_stack(pair)
            for pair in ((side, 0 * side), (1 + 0 * side, side), (1 - side, 1 + 0 * side), (0 * side, 1 - side))
        ]
    )
    points = np.array([[0.5, 0.5], [0.5, 0.1], [2.0, 0.5], [0.5, -0.25]])
    assert signed_distance(points, square) == pytest.approx([0.5, 0.1, -1.0, -0.25], abs=1e-12)


def test_specks_and_pinholes_are_mended_with_notes():
    x, y, z = oval_dome()
    clean = target_from_heights("dome", x, y, z)
    z[60, 40] = z[61, 40] = z[30, 30] = np.nan
    z[1, 1] = z[2, 1] = 5.0
    target = target_from_heights("dome", x, y, z)
    assert len(target.notes) == 2
    assert "1 loose specks (0.12 mm2" in target.notes[0]
    assert "2 pinholes (0.19 mm2" in target.notes[1]
    assert np.nanmax(np.abs(target.z_mm - clean.z_mm)) < 0.01
    assert np.array_equal(np.isfinite(target.z_mm), np.isfinite(clean.z_mm))


def broken(name):
    x, y, z = oval_dome()
    if name == "pieces":
        z[50:54] = np.nan
    elif name == "hole":
        z[50:60, 30:40] = np.nan
    elif name == "constant":
        z[np.isfinite(z)] = 3.0
    elif name == "nan":
        z[:] = np.nan
    elif name == "infinite":
        z[40, 40] = np.inf
    elif name == "uneven":
        x = x.copy()
        x[10] += 0.05
    elif name == "axis":
        y = y.copy()
        y[3] = np.nan
    elif name == "shape":
        z = z.T
    elif name == "small":
        x, z = x[:3], z[:, :3]
    elif name == "strip":
        z[:] = np.nan
        z[40:42] = 1.0
    return x, y, z


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("pieces", ["2 separate pieces", "mm2 around x =", "one film needs one piece"]),
        ("hole", ["1 holes", "6.25 mm2 around x = -1.375, y = -1.375", "fill the holes"]),
        ("constant", ["constant", "up direction"]),
        ("nan", ["NaN everywhere"]),
        ("infinite", ["1 infinite", "row 40, column 40"]),
        ("uneven", ["x_mm is not evenly spaced", "entry 10"]),
        ("axis", ["y_mm holds 1 NaN"]),
        ("shape", ["(81, 121)", "(ny, nx)"]),
        ("small", ["3 columns and 121 rows"]),
        ("strip", ["constant"]),
    ],
)
def test_wrong_heights_are_refused_with_one_clear_sentence(name, words):
    with pytest.raises(InputError) as caught:
        target_from_heights("my dome", *broken(name))
    assert len(caught.value.problems) == 1
    for word in ["my dome: ", *words]:
        assert word in caught.value.problems[0]


def test_all_problems_are_collected():
    x, y, z = broken("pieces")
    z[70:80, 35:45] = np.nan
    with pytest.raises(InputError) as caught:
        target_from_heights("dome", x, y, z)
    assert len(caught.value.problems) == 2


def dome() -> Target:
    return target_from_heights("dome", *oval_dome())


def test_surface_matches_the_formula_inside_and_is_nan_outside():
    target = dome()
    surface = Surface(target)
    rng = np.random.default_rng(5)
    points = rng.uniform(-16, 16, (5000, 2))
    radius = np.hypot(points[:, 0] / 10, points[:, 1] / 15)
    height = surface.height(points)
    assert np.isfinite(height[radius < 0.98]).all()
    assert np.isnan(height[radius > 1.02]).all()
    assert np.array_equal(np.isfinite(height), surface.inside(points))
    expected = 4.5 - 0.02 * (points**2).sum(axis=1)
    inside = surface.inside(points)
    assert np.abs(height - expected)[inside].max() < 0.02
    slope = surface.gradient(points)
    assert np.abs(slope + 0.04 * points)[inside].max() < 0.03
    assert np.isnan(slope[~inside]).all()
    assert surface.height(points.reshape(50, 100, 2)).shape == (50, 100)


def test_surface_continues_planes_exactly_beyond_the_outline():
    x, y, X, Y = grid(10.0, 10.0)
    z = 1.0 + 0.3 * X - 0.2 * Y
    z[X**2 + Y**2 > 16] = np.nan
    target = target_from_heights("slope", x, y, z)
    surface = Surface(target)
    assert surface.extended_height(1.05 * target.outline_mm) == pytest.approx(
        surface.extended_height(np.zeros(2)) + 1.05 * target.outline_mm @ [0.3, -0.2], abs=1e-4
    )
    assert surface.gradient(0.9 * target.outline_mm, smoothing_mm=1.0) == pytest.approx(
        np.tile([0.3, -0.2], (len(target.outline_mm), 1)), abs=1e-4
    )
    assert surface.clearance_mm(target.outline_mm) == pytest.approx(0.0, abs=0.05)
