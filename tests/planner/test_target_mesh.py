import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.errors import InputError
from planner.target import mesh_outline, sample_surface, surface_mesh, target_from_heights
from planner.target.outline import signed_area

SQUARE = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])


def oval(a, b, count=300):
    s = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
    return np.column_stack((a * np.cos(s), b * np.sin(s)))


def areas(points, triangles):
    a, b = (points[triangles[:, k]] - points[triangles[:, 0]] for k in (1, 2))
    return 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def angles_deg(points, triangles):
    corners = points[triangles]
    ahead, behind = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    lengths = np.linalg.norm(ahead, axis=2) * np.linalg.norm(behind, axis=2)
    return np.degrees(np.arccos(np.einsum("tik,tik->ti", ahead, behind) / lengths))


def edges(triangles):
    ends = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return np.unique(ends, axis=0, return_counts=True)


def check(points, triangles, edge, area, holes=0, smallest_deg=25.0):
    assert areas(points, triangles).min() > 0
    assert areas(points, triangles).sum() == pytest.approx(area, rel=0.02)
    assert angles_deg(points, triangles).min() > smallest_deg
    ends, uses = edges(triangles)
    assert uses.max() == 2
    assert len(points) - len(ends) + len(triangles) == 1 - holes
    assert len(np.unique(triangles)) == len(points)
    border = np.unique(ends[uses == 1])
    assert not np.isin(triangles, border).all(axis=1).any()
    assert np.array_equal(border, np.arange(len(border)))
    lengths = np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1)
    assert lengths.min() > 0.55 * edge
    assert lengths.max() < 1.8 * edge


def test_a_square_keeps_its_corners_and_edges():
    points, triangles = mesh_outline(SQUARE, 0.6)
    check(points, triangles, 0.6, 100.0)
    for corner in SQUARE:
        assert np.linalg.norm(points - corner, axis=1).min() < 1e-9
    assert signed_area(points[: 4 * 17]) == pytest.approx(100.0)


@settings(max_examples=20, deadline=None)
@given(a=st.floats(4, 12), b=st.floats(4, 12), angle=st.floats(0, 3), edge=st.floats(0.5, 1.0))
def test_ovals_and_turned_rectangles_are_well_meshed(a, b, angle, edge):
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    check(*mesh_outline(oval(a, b) @ turn, edge), edge, np.pi * a * b, smallest_deg=22.0)
    box = (SQUARE / 5 - 1) * [a, b] @ turn
    check(*mesh_outline(box, edge), edge, 4 * a * b, smallest_deg=22.0)


def test_holes_are_left_out():
    hole = oval(3, 3)
    points, triangles = mesh_outline(oval(10, 12), 0.7, (hole, hole[::-1] * 0.5 + [0, 7]))
    check(points, triangles, 0.7, np.pi * (120 - 9 - 2.25), holes=2)


def test_a_clockwise_outline_gives_the_same_mesh_quality():
    points, triangles = mesh_outline(SQUARE[::-1], 0.6)
    check(points, triangles, 0.6, 100.0)


def test_the_mesh_is_deterministic_and_fast():
    began = time.process_time()
    points, triangles = mesh_outline(oval(20, 30), 0.46)
    assert time.process_time() - began < 5.0
    assert len(triangles) > 20_000
    again = mesh_outline(oval(20, 30), 0.46)
    assert np.array_equal(points, again[0])
    assert np.array_equal(triangles, again[1])


@pytest.mark.parametrize("edge", [0.0, -1.0, np.nan])
def test_edge_lengths_must_be_positive(edge):
    with pytest.raises(InputError, match="positive length"):
        mesh_outline(SQUARE, edge)


def test_an_outline_narrower_than_the_edges_is_refused():
    needle = np.array([[0, 0], [5, -5], [10, 0], [5, 5], [4.9999, 0.0], [10, 4], [0, 4.0]])
    with pytest.raises(InputError, match="narrower than the edge length"):
        mesh_outline(needle, 2.0)


def ridge():
    x, y = np.linspace(-10, 10, 81), np.linspace(-5, 5, 41)
    X, _ = np.meshgrid(x, y)
    return target_from_heights("ridge", x, y, 4 * np.exp(-(X**2)))


def test_the_surface_mesh_lies_on_the_surface():
    target = ridge()
    vertices, triangles = surface_mesh(target, 0.5)
    assert vertices[:, 2] == pytest.approx(4 * np.exp(-(vertices[:, 0] ** 2)), abs=0.06)
    assert areas(vertices[:, :2], triangles).sum() == pytest.approx(200.0, rel=5e-3)


@pytest.mark.parametrize("spacing", [0.1, 0.4])
def test_samples_leave_no_gap_along_the_surface(spacing):
    points = sample_surface(ridge(), spacing)
    assert np.array_equal(points, sample_surface(ridge(), spacing))
    # Walk along the ridge's profile: in each strip one sample wide the steps are at most the spacing.
    strip = points[np.abs(points[:, 1] - points[0, 1]) < 1e-9]
    strip = strip[np.argsort(strip[:, 0])]
    inner = np.abs(strip[:, 0]) < 9.9
    assert np.linalg.norm(np.diff(strip[inner], axis=0), axis=1).max() <= spacing * 1.15
    assert len(points) > 200.0 / spacing**2


def test_sample_spacing_must_be_positive():
    with pytest.raises(InputError, match="positive length"):
        sample_surface(ridge(), 0.0)
