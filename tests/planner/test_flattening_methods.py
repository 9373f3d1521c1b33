from collections.abc import Callable
from pathlib import Path
from typing import Literal, cast

import numpy as np
import pytest

from planner.errors import InputError
from planner.flattening import distortion, film_outline, flatten, map_directions, map_points
from planner.flattening.arap import slim_film_positions
from planner.flattening.orientation import signed_double_areas
from planner.target import Target, surface_mesh, target_from_heights

Method = Literal["arap", "grid"]
METHODS: tuple[Method, ...] = ("arap", "grid")


def make(
    height: Callable[[np.ndarray, np.ndarray], np.ndarray], *, width: float = 16.0, length: float = 20.0
) -> Target:
    x_mm = np.arange(-width / 2, width / 2 + 0.05, 0.1)
    y_mm = np.arange(-length / 2, length / 2 + 0.05, 0.1)
    x, y = np.meshgrid(x_mm, y_mm)
    inside = (2 * x / width) ** 2 + (2 * y / length) ** 2 <= 1
    return target_from_heights("test surface", x_mm, y_mm, np.where(inside, height(x, y), np.nan))


def dome() -> Target:
    return make(lambda x, y: 6 * np.sqrt(np.clip(1 - (x**2 + y**2) / 144, 0, 1)), width=21.6, length=21.6)


def cylinder(turn_rad: float) -> Target:
    """Radius 12 mm; `turn_rad` is the direction across it."""

    def height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        across = np.cos(turn_rad) * x + np.sin(turn_rad) * y
        return np.sqrt(np.clip(12.0**2 - across**2, 0, None))

    return make(height)


def lopsided(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """A hill up and to the right, a small hollow below it: no symmetry hides a turn or a mirror image."""
    return 3 * np.exp(-((x - 2) ** 2 + (y - 4) ** 2) / 8) - np.exp(-(x**2 + (y + 4) ** 2) / 4)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("slope", [(0.0, 0.9), (0.7, -0.5)])
def test_plane_is_isometric(method: Method, slope: tuple[float, float]) -> None:
    stretch = distortion(flatten(make(lambda x, y: slope[0] * x + slope[1] * y), method=method))
    assert stretch.length_max < 1e-3
    assert stretch.area_max < 1e-3


@pytest.mark.parametrize("turn_rad", [0.0, np.pi / 2, 0.6])
def test_cylinder_is_isometric(turn_rad: float) -> None:
    target = cylinder(turn_rad)
    flat = flatten(target, method="arap")
    assert distortion(flat).area_max < 1e-3
    assert distortion(flat).length_max < 1e-3
    # Across the cylinder the film is as wide as the arc is long: 2 R asin(half chord / R).
    if turn_rad == 0.0:
        chord = np.array([[-6.0, 0.0], [6.0, 0.0]])
        width = np.linalg.norm(np.diff(map_points(flat, chord), axis=0))
        assert width == pytest.approx(2 * 12.0 * np.arcsin(6.0 / 12.0), rel=2e-3)


@pytest.mark.parametrize("turn_rad", [0.0, np.pi / 2])
def test_cylinder_along_the_grid_keeps_lengths(turn_rad: float) -> None:
    # Each block is flat, so a chord replaces the arc: 1 - sin(a) / a with a = 1 mm / (2 * 12 mm) stays below 0.1 %;
    # the rest is that a block's stretch is its mean one.
    target = cylinder(turn_rad)
    stretch = distortion(flatten(target, method="grid", block_mm=1.0))
    assert stretch.length_median < 0.002
    assert stretch.length_95 < 0.01


@pytest.mark.parametrize("method", METHODS)
def test_film_is_upright_and_in_place(method: Method) -> None:
    flat = flatten(make(lopsided), method=method)
    assert flat.method == method
    assert (signed_double_areas(flat.film_mm, flat.triangles) > 0).all()
    moved = flat.film_mm - flat.vertices_mm[:, :2]
    assert moved.mean(axis=0) == pytest.approx([0, 0], abs=1e-9)
    # No turn is left: the film against the surface seen from above.
    film, seen = (p - p.mean(axis=0) for p in (flat.film_mm, flat.vertices_mm[:, :2]))
    assert (film[:, 0] * seen[:, 1] - film[:, 1] * seen[:, 0]).sum() == pytest.approx(0, abs=1e-6)
    top = map_points(flat, np.array([[2.0, 4.0]]))[0]
    assert top == pytest.approx([2.0, 4.0], abs=1.5)


@pytest.mark.parametrize("method", METHODS)
def test_dome_of_the_paper(method: Method) -> None:
    flat = flatten(dome(), method=method)
    stretch = distortion(flat)
    # The film is wider than the dome seen from above, by about the arc over the chord.
    assert np.ptp(film_outline(flat), axis=0) == pytest.approx([22.8, 22.8], abs=0.4)
    assert stretch.length_95 < (0.04 if method == "arap" else 0.08)
    assert abs(stretch.total_area) < (0.002 if method == "arap" else 0.03)
    assert stretch.length_median <= stretch.length_95 <= stretch.length_max


def test_steep_walls_cannot_fold() -> None:
    vertices, triangles = surface_mesh(make(lambda x, y: 8 * np.sin(1.5 * x) * np.cos(1.3 * y)), 0.8)
    film = slim_film_positions(vertices, triangles)
    assert (signed_double_areas(film, triangles) > 0).all()


def test_folds_are_answered() -> None:
    target = make(lambda x, y: 8 * np.sin(1.5 * x) * np.cos(1.3 * y))
    with pytest.raises(InputError, match=r"folds \d+ of \d+ triangles"):
        flatten(target, method="grid", block_mm=1.0)
    flat = flatten(target, method="arap")
    assert (signed_double_areas(flat.film_mm, flat.triangles) > 0).all()
    assert len(flat.notes) == 1
    assert "symmetric Dirichlet" in flat.notes[0]


def test_all_problems_are_named_at_once() -> None:
    with pytest.raises(InputError) as caught:
        flatten(dome(), method=cast(Method, "iron"), edge_mm=0.0, block_mm=float("nan"))
    assert len(caught.value.problems) == 3


@pytest.mark.shared
@pytest.mark.parametrize("method", METHODS)
def test_face(shared_dir: Path, method: Method) -> None:
    with np.load(shared_dir / "targets" / "ict_mean.npz") as data:
        target = target_from_heights("ict_mean", data["x_mm"], data["y_mm"], data["z_mm"])
    flat = flatten(target, method=method)
    stretch = distortion(flat)
    assert stretch.length_median < (0.04 if method == "arap" else 0.12)
    assert abs(stretch.total_area) < (0.03 if method == "arap" else 0.3)
    # Brow, nose and chin stay in their order, brow up; the left cheek stays on the left.
    brow, nose, chin, left, right = map_points(
        flat, np.array([[0.0, 20.0], [0.0, 0.0], [0.0, -25.0], [-15.0, 0.0], [15.0, 0.0]])
    )
    assert brow[1] > nose[1] + 15 > chin[1] + 30
    assert left[0] < nose[0] - 12
    assert right[0] > nose[0] + 12
    across = map_directions(flat, np.array([[0.0, 20.0]]), np.array([0.1]))
    assert across == pytest.approx([0.1], abs=0.15)
