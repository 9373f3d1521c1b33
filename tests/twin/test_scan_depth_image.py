import importlib

import numpy as np
import pytest

from planner.target import target_from_heights
from twin.scan import depth_image, grey_image, grid_triangles, pixel_centres, target_depth_image

BOX = (np.array([0.0, 0.0]), np.array([4.0, 3.0]))


def test_one_triangle_by_hand():
    # Legs of 2 on the axes: of the 4 x 3 pixels only those with centre x + y <= 2 are covered; z = 1 + x.
    vertices = np.array([[0.0, 0.0, 1.0], [2.0, 0.0, 3.0], [0.0, 2.0, 1.0]])
    image = depth_image(vertices, np.array([[0, 1, 2]]), BOX, (4, 3))
    expected = np.full((3, 4), np.nan)
    expected[2, 0], expected[2, 1], expected[1, 0] = 1.5, 2.5, 1.5
    np.testing.assert_allclose(image, expected)


def test_the_topmost_surface_is_seen_whatever_the_orientation():
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    low, high = np.column_stack([square, np.full(4, 1.0)]), np.column_stack([square, np.full(4, 2.0)])
    for triangles in ([[4, 5, 6], [4, 6, 7], [0, 1, 2], [0, 2, 3]], [[2, 1, 0], [3, 2, 0], [6, 5, 4], [7, 6, 4]]):
        image = depth_image(np.concatenate([low, high]), np.array(triangles), BOX, (4, 3))
        np.testing.assert_allclose(image, 2.0)


def test_a_plane_in_many_small_triangles_has_no_pinholes():
    x, y = np.linspace(-1, 5, 61), np.linspace(-1, 4, 51)
    plane = 0.3 * x[None, :] - 0.2 * y[:, None]
    image = depth_image(*grid_triangles(x, y, plane), BOX, (40, 30))
    xy = pixel_centres(BOX, (40, 30))
    np.testing.assert_allclose(image, 0.3 * xy[..., 0] - 0.2 * xy[..., 1], atol=1e-12)


def test_a_vertical_wall_and_what_lies_outside_draw_nothing():
    wall = np.array([[1.0, 0.0, 0.0], [1.0, 3.0, 0.0], [1.0, 3.0, 5.0]])
    away = np.array([[10.0, 0.0, 0.0], [12.0, 0.0, 0.0], [10.0, 2.0, 0.0]])
    image = depth_image(np.concatenate([wall, away]), np.array([[0, 1, 2], [3, 4, 5]]), BOX, (4, 3))
    assert np.isnan(image).all()


def test_rows_run_from_plus_y_down_and_columns_from_minus_x():
    xy = pixel_centres(BOX, (4, 3))
    assert xy.shape == (3, 4, 2)
    np.testing.assert_allclose(xy[0, 0], [0.5, 2.5])
    np.testing.assert_allclose(xy[2, 3], [3.5, 0.5])


def test_a_target_and_its_triangles_look_alike():
    x, y = np.arange(-10, 10.1, 0.25), np.arange(-14, 14.1, 0.25)
    X, Y = np.meshgrid(x, y)
    z = np.where((X / 10) ** 2 + (Y / 14) ** 2 <= 1, 5 - 0.02 * X**2 + 0.1 * Y, np.nan)
    target = target_from_heights("bowl", x, y, z)
    of_target = target_depth_image(target)
    of_mesh = depth_image(*grid_triangles(target.x_mm, target.y_mm, target.z_mm), target.bounds_mm)
    assert of_target.shape == (168, 104)
    both = np.isfinite(of_target) & np.isfinite(of_mesh)
    assert both.sum() > 0.97 * np.isfinite(of_target).sum()
    assert np.abs(of_target - of_mesh)[both].max() < 5e-3
    # The plane rises towards +y: the top of the image is high.
    assert np.nanmean(of_target[:84]) > np.nanmean(of_target[84:])


def test_grey_keeps_one_scale_and_never_clips():
    grey = grey_image(np.array([[0.0, 10.0, 5.0, 20.0, -5.0, np.nan]]), 0.0, 10.0)
    np.testing.assert_allclose(grey, [[1.0, 255.0, 128.0, 509.0, -126.0, 0.0]])


def test_large_triangles_are_drawn_in_parts(monkeypatch):
    monkeypatch.setattr(importlib.import_module("twin.scan.depth_image"), "_PAIRS_AT_ONCE", 7)
    x, y = np.linspace(0, 4, 5), np.linspace(0, 3, 4)
    image = depth_image(*grid_triangles(x, y, np.ones((4, 5))), BOX, (8, 6))
    np.testing.assert_allclose(image, 1.0)


@pytest.mark.shared
def test_the_shared_face_is_upright(shared_dir):
    data = np.load(shared_dir / "targets" / "ict_mean.npz")
    target = target_from_heights("face", data["x_mm"], data["y_mm"], data["z_mm"])
    image = target_depth_image(target)
    row, column = np.unravel_index(np.nanargmax(image), image.shape)
    # The tip of the nose lies a little below the middle, on the axis.
    assert 70 < row < 110
    assert 45 < column < 59
