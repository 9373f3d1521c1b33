import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.flattening import Flattening, distortion, film_outline, locate, map_directions, map_points
from planner.flattening.blocks import BlockPlanes, merge_rings
from planner.flattening.orientation import place_upright


def square_film(matrix: np.ndarray, *, side: int = 21, lift: float = 0.0) -> Flattening:
    """A square sheet of 10 x 10 mm, its heights lift * x, laid flat by one 2 x 2 matrix."""
    axis = np.linspace(-5, 5, side)
    x, y = np.meshgrid(axis, axis)
    xy = np.column_stack([x.ravel(), y.ravel()])
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    lower = np.column_stack([corner, corner + 1, corner + side + 1])
    upper = np.column_stack([corner, corner + side + 1, corner + side])
    return Flattening(
        method="arap",
        vertices_mm=np.column_stack([xy, lift * xy[:, 0]]),
        triangles=np.vstack([lower, upper]),
        film_mm=xy @ matrix.T,
    )


SHEAR = np.array([[1.2, 0.3], [0.1, 0.9]])


def test_points_follow_the_linear_map() -> None:
    rng = np.random.default_rng(1)
    xy = rng.uniform(-5, 5, (2000, 2))
    assert map_points(square_film(SHEAR), xy) == pytest.approx(xy @ SHEAR.T, abs=1e-12)


def test_outside_is_nan_and_the_rim_belongs_to_it() -> None:
    film = square_film(SHEAR)
    xy = np.array([[5.2, 0.0], [5.01, 0.0], [np.nan, 0.0], [0.0, 0.0]])
    mapped = map_points(film, xy)
    assert np.isnan(mapped[[0, 2]]).all()
    assert mapped[1] == pytest.approx(SHEAR @ [5.01, 0.0])
    assert np.isnan(map_directions(film, xy, np.zeros(4))).tolist() == [True, False, True, False]
    assert locate(film, xy).triangle[[0, 2]].tolist() == [-1, -1]
    assert map_points(film, np.zeros((0, 2))).shape == (0, 2)


@given(angle=st.floats(-10, 10))
def test_directions_follow_the_linear_map_modulo_half_a_turn(angle: float) -> None:
    mapped = map_directions(square_film(SHEAR, side=3), np.array([[0.3, 0.2]]), np.array([angle]))[0]
    pushed = SHEAR @ [np.cos(angle), np.sin(angle)]
    assert 0 <= mapped < np.pi
    assert np.sin(mapped - np.arctan2(pushed[1], pushed[0])) == pytest.approx(0, abs=1e-9)


def test_direction_across_an_incline_turns_with_its_length() -> None:
    # A plane inclined 60 degrees along x is twice as long on the film: 45 degrees seen from above become atan(1/2).
    film = square_film(np.diag([2.0, 1.0]), lift=np.sqrt(3.0))
    mapped = map_directions(film, np.zeros((1, 2)), np.array([np.pi / 4]))
    assert mapped == pytest.approx([np.arctan(0.5)])
    assert distortion(film).area_max == pytest.approx(0, abs=1e-12)
    assert distortion(film).length_max == pytest.approx(0, abs=1e-12)


def test_distortion_of_a_stretched_sheet() -> None:
    stretch = distortion(square_film(np.diag([1.1, 1.1])))
    assert stretch.length_median == pytest.approx(0.1)
    assert stretch.length_max == pytest.approx(0.1)
    assert stretch.area_95 == pytest.approx(0.21)
    assert stretch.total_area == pytest.approx(0.21)


def test_outline_runs_counter_clockwise() -> None:
    x, y = film_outline(square_film(np.eye(2))).T
    assert len(x) == 80
    assert 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)) == pytest.approx(100.0)


@given(turn=st.floats(-3, 3), shift_x=st.floats(-9, 9), shift_y=st.floats(-9, 9))
def test_place_upright_undoes_a_rigid_motion(turn: float, shift_x: float, shift_y: float) -> None:
    seen = np.random.default_rng(0).uniform(-5, 5, (40, 2))
    cosine, sine = np.cos(turn), np.sin(turn)
    film = seen @ np.array([[cosine, sine], [-sine, cosine]]) + [shift_x, shift_y]
    assert place_upright(film, seen) == pytest.approx(seen, abs=1e-9)


def test_blocks_by_hand() -> None:
    # Three blocks of 1 mm in a row, the peak in the middle; the right one is inclined by slope sqrt(3) along x, so
    # that it is 2 mm long on the film. Edge blocks align the mid-points of the shared edges: no gap is left.
    slope = np.zeros((1, 3, 2))
    slope[0, 2, 0] = np.sqrt(3.0)
    nodes = merge_rings(BlockPlanes(np.zeros(2), 1.0, slope, (0, 1)))
    assert nodes[0, :, 0] - nodes[0, 1, 0] == pytest.approx([-1, 0, 1, 3])
    assert nodes[1, :, 0] - nodes[0, :, 0] == pytest.approx([0, 0, 0, 0])
    assert nodes[1, :, 1] - nodes[0, :, 1] == pytest.approx([1, 1, 1, 1])


def test_shared_corner_takes_the_mean() -> None:
    # 3 x 3 level blocks, but the block right of the peak is 2 mm long: its outer nodes start at 2.5 mm from the
    # centre, those of the corner blocks beside it at 1.5 mm; a shared node takes their mean.
    slope = np.zeros((3, 3, 2))
    slope[1, 2, 0] = np.sqrt(3.0)
    nodes = merge_rings(BlockPlanes(np.zeros(2), 1.0, slope, (1, 1)))
    centre = nodes[1:3, 1:3].mean(axis=(0, 1))
    assert nodes[1, 3] - centre == pytest.approx([2.0, -0.5])
    assert nodes[2, 3] - centre == pytest.approx([2.0, 0.5])
    assert nodes[0, 3] - centre == pytest.approx([1.5, -1.5])


def test_half_a_million_points_in_time() -> None:
    film = square_film(np.eye(2), side=61)
    xy = np.random.default_rng(0).uniform(-5, 5, (500_000, 2))
    start = time.process_time()
    located = locate(film, xy)
    map_points(film, xy, located=located)
    map_directions(film, xy, xy[:, 0], located=located)
    assert time.process_time() - start < 5.0
