import time
from collections.abc import Callable
from pathlib import Path
from typing import Literal, cast

import numpy as np
import pytest

from planner.curvature import CurvatureField, curvature_field
from planner.errors import InputError
from planner.target import Target, target_from_heights

Method = Literal["perpendicular", "maximum"]
METHODS: tuple[Method, ...] = ("perpendicular", "maximum")


def make(
    height: Callable[[np.ndarray, np.ndarray], np.ndarray], *, radius_mm: float = 6.0, turn_rad: float = 0.0
) -> Target:
    axis = np.arange(-radius_mm, radius_mm + 0.05, 0.1)
    x, y = np.meshgrid(axis, axis)
    u = np.cos(turn_rad) * x + np.sin(turn_rad) * y
    v = -np.sin(turn_rad) * x + np.cos(turn_rad) * y
    z = np.where(x**2 + y**2 <= radius_mm**2, height(u, v), np.nan)
    return target_from_heights("test surface", axis, axis, z)


def sphere(radius_mm: float, sign: float = 1.0) -> Target:
    return make(lambda x, y: sign * np.sqrt(radius_mm**2 - x**2 - y**2))


def line_difference(a: np.ndarray, b: np.ndarray | float) -> np.ndarray:
    return abs(np.mod(a - b + np.pi / 2, np.pi) - np.pi / 2)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_sphere_bends_by_its_radius(method: Method, sign: float) -> None:
    field = curvature_field(sphere(10.0, sign), method=method, plane="normal", spacing_mm=0.2)
    # Within the smoothing window of the outline the incline is one-sided, and with it the cosine of `normal`.
    inner = np.linalg.norm(field.points_mm[:, :2], axis=1) < 5.0
    assert field.curvature_per_mm[inner] == pytest.approx(sign / 10.0, rel=0.01)
    assert field.curvature_per_mm == pytest.approx(sign / 10.0, rel=0.03)


def test_vertical_plane_cuts_a_smaller_circle_from_a_sphere() -> None:
    # Along the contour, at distance r from the axis, the vertical plane cuts a circle of radius sqrt(R^2 - r^2).
    field = curvature_field(sphere(10.0), method="perpendicular", spacing_mm=0.2)
    away = np.linalg.norm(field.points_mm[:, :2], axis=1)
    assert field.curvature_per_mm == pytest.approx(1 / np.sqrt(100.0 - away**2), rel=0.01)


@pytest.mark.parametrize("turn_rad", [0.0, 0.5, 2.5])
def test_cylinder(turn_rad: float) -> None:
    target = make(lambda u, v: np.sqrt(12.0**2 - u**2), turn_rad=turn_rad)
    across = curvature_field(target, method="maximum", spacing_mm=0.25)
    assert across.curvature_per_mm == pytest.approx(1 / 12.0, rel=0.015)
    assert np.percentile(line_difference(across.direction_rad, turn_rad), 95) < np.deg2rad(6)
    along = curvature_field(target, method="perpendicular", spacing_mm=0.25)
    flank = abs(along.points_mm[:, :2] @ [np.cos(turn_rad), np.sin(turn_rad)]) > 1.0
    assert abs(along.curvature_per_mm[flank]).max() < 2e-3
    assert np.percentile(line_difference(along.direction_rad[flank], turn_rad + np.pi / 2), 95) < np.deg2rad(2)


@pytest.mark.parametrize("method", METHODS)
def test_inclined_plane_is_flat(method: Method) -> None:
    field = curvature_field(make(lambda x, y: 0.8 * x - 0.3 * y), method=method, spacing_mm=0.25)
    assert abs(field.curvature_per_mm).max() < 1e-6


def test_saddle_bends_both_ways() -> None:
    target = make(lambda x, y: (x**2 - y**2) / 40.0)
    field = curvature_field(target, method="maximum", spacing_mm=0.25)
    up_along_x = line_difference(field.direction_rad, 0.0) < np.deg2rad(20)
    down_along_y = line_difference(field.direction_rad, np.pi / 2) < np.deg2rad(20)
    assert up_along_x.sum() > 100
    assert down_along_y.sum() > 100
    assert (field.curvature_per_mm[up_along_x] < 0).all()
    assert (field.curvature_per_mm[down_along_y] > 0).all()
    assert np.median(abs(field.curvature_per_mm)) == pytest.approx(1 / 20, rel=0.1)


@pytest.mark.parametrize("method", METHODS)
def test_turning_the_target_turns_the_field(method: Method) -> None:
    def ellipsoid(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        return 5.0 * np.sqrt(1.3 - (u / 8.0) ** 2 - (v / 11.0) ** 2)

    turn = 0.7
    straight = curvature_field(make(ellipsoid), method=method, spacing_mm=0.25)
    turned = curvature_field(make(ellipsoid, turn_rad=turn), method=method, spacing_mm=0.25)
    cosine, sine = np.cos(turn), np.sin(turn)
    back = turned.points_mm[:, :2] @ np.array([[cosine, -sine], [sine, cosine]])
    gap = np.linalg.norm(straight.points_mm[:, None, :2] - back[None, ::17], axis=2)
    nearest = gap.argmin(axis=0)
    # Near the peak the surface is level and the direction has no meaning.
    flank = (gap.min(axis=0) < 0.2) & (np.linalg.norm(back[::17], axis=1) > 2.0)
    turned_by = line_difference(turned.direction_rad[::17] - turn, straight.direction_rad[nearest])[flank]
    assert np.percentile(turned_by, 95) < np.deg2rad(8)
    assert turned.curvature_per_mm[::17][flank] == pytest.approx(straight.curvature_per_mm[nearest][flank], rel=0.1)


def test_points_near_the_outline_are_dropped() -> None:
    target = make(lambda x, y: -(x**2 + y**2) / 200.0)
    perpendicular = curvature_field(target, method="perpendicular", spacing_mm=0.2)
    maximum = curvature_field(target, method="maximum", spacing_mm=0.2)
    # Of a nearly flat disc of 6 mm radius, every orientation's neighbours are inside up to 4 mm; along the contour
    # they are up to sqrt(36 - 4) mm.
    assert np.linalg.norm(maximum.points_mm[:, :2], axis=1).max() == pytest.approx(4.0, abs=0.1)
    assert maximum.dropped_share == pytest.approx(1 - (4 / 6) ** 2, abs=0.02)
    assert np.linalg.norm(perpendicular.points_mm[:, :2], axis=1).max() == pytest.approx(32**0.5, abs=0.1)
    assert perpendicular.dropped_share == pytest.approx(4 / 36, abs=0.02)


def test_all_problems_are_named_at_once() -> None:
    with pytest.raises(InputError) as caught:
        curvature_field(sphere(10.0), method=cast(Method, "mean"), neighbour_mm=-1.0, spacing_mm=float("nan"))
    assert len(caught.value.problems) == 3


def test_target_smaller_than_the_circle() -> None:
    with pytest.raises(InputError, match="beyond the outline"):
        curvature_field(sphere(10.0), method="maximum", neighbour_mm=7.0, spacing_mm=0.5)


def read(shared_dir: Path, name: str) -> Target:
    with np.load(shared_dir / "targets" / f"{name}.npz") as data:
        return target_from_heights(name, data["x_mm"], data["y_mm"], data["z_mm"])


def between(field: CurvatureField, x: tuple[float, float], y: tuple[float, float]) -> np.ndarray:
    px, py = field.points_mm[:, 0], field.points_mm[:, 1]
    return field.curvature_per_mm[(px > x[0]) & (px < x[1]) & (py > y[0]) & (py < y[1])]


@pytest.mark.shared
def test_face(shared_dir: Path) -> None:
    start = time.process_time()
    field = curvature_field(read(shared_dir, "ict_mean"), method="perpendicular")
    assert time.process_time() - start < 4.0
    radius = 1 / abs(field.curvature_per_mm)
    # The paper's face: 3 % of the points sharper than 1.8 mm, 41 % flatter than 14.4 mm.
    assert (radius < 1.8).mean() == pytest.approx(0.03, abs=0.02)
    assert (radius > 14.4).mean() == pytest.approx(0.41, abs=0.08)
    assert np.median(between(field, (-1, 1), (3, 9))) > 0.2, "the ridge of the nose is convex"
    assert np.median(between(field, (5, 8), (9, 12))) < -0.05, "the corner of the eye is concave"


@pytest.mark.shared
def test_face_in_all_orientations(shared_dir: Path) -> None:
    target = read(shared_dir, "ict_mean")
    maximum = curvature_field(target, method="maximum", spacing_mm=0.2)
    perpendicular = curvature_field(target, method="perpendicular", spacing_mm=0.2)
    assert np.median(abs(maximum.curvature_per_mm)) > 1.3 * np.median(abs(perpendicular.curvature_per_mm))
    assert maximum.dropped_share > perpendicular.dropped_share
