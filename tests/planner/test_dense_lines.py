import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from scipy.spatial import Delaunay

from planner.errors import InputError
from planner.toolpaths.dense import MeshField, dense_lines, tiling

Mesh = tuple[np.ndarray, np.ndarray]


def sheet(width: float, height: float) -> Mesh:
    axes = [np.linspace(-side / 2, side / 2, round(side) + 1) for side in (width, height)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    return points, Delaunay(points).simplices


def director(angle: np.ndarray) -> np.ndarray:
    return 0.2 * np.stack([np.cos(2 * angle), np.sin(2 * angle)], axis=1)


@pytest.fixture(scope="module")
def film() -> Mesh:
    return sheet(24, 18)


@pytest.mark.parametrize("name", ["constant", "azimuth", "plus half", "minus half"])
def test_lines_tile_the_film_along_the_director(film: Mesh, name: str) -> None:
    points, triangles = film
    around = np.arctan2(points[:, 1], points[:, 0])
    angle = {
        "constant": np.full(len(points), 0.4),
        "azimuth": around + np.pi / 2,
        "plus half": around / 2,
        "minus half": -around / 2,
    }
    field = MeshField(points_mm=points, triangles=triangles, q=director(angle[name]))
    found = tiling(dense_lines(field), field)
    assert found.coverage >= 0.97
    assert found.overlap <= 0.03
    assert found.deviation_median_deg <= 5
    assert found.deviation_95_deg <= 15


@pytest.mark.parametrize("seed", [1, 2])
def test_smooth_random_fields_with_islands_are_tiled(film: Mesh, seed: int) -> None:
    points, triangles = film
    rough = np.random.default_rng(seed).normal(size=(25, 19, 2))
    field = MeshField(points_mm=points, triangles=triangles, q=gaussian_filter(rough, (4, 4, 0)).reshape(-1, 2))
    least = float(np.percentile(np.linalg.norm(field.q, axis=1), 10))
    lines = dense_lines(field, least=least)
    found = tiling(lines, field, least=least)
    assert found.coverage >= 0.96
    assert found.overlap <= 0.03
    assert found.deviation_median_deg <= 5
    assert found.deviation_95_deg <= 16
    assert dense_lines(field, least=least)[0].tolist() == lines[0].tolist()


def test_lines_stay_in_what_is_wanted_and_turn_gently(film: Mesh) -> None:
    points, triangles = film
    wanted = np.hypot(*points.T) < 7
    q = director(np.full(len(points), 1.0)) * wanted[:, None]
    lines = dense_lines(MeshField(points_mm=points, triangles=triangles, q=q))
    every = np.concatenate(lines)
    assert np.hypot(*every.T).max() < 8.2
    for line in lines:
        ahead = np.diff(line, axis=0) @ np.array([1, 1j])
        assert np.all(np.abs(np.angle(ahead[1:] / ahead[:-1])) < 0.5)


def test_lines_round_a_centre_are_few(film: Mesh) -> None:
    points, triangles = film
    around = np.arctan2(points[:, 1], points[:, 0]) + np.pi / 2
    lines = dense_lines(MeshField(points_mm=points, triangles=triangles, q=director(around)))
    # Rings and spirals inside, arcs between the corners: 24 x 18 mm / 0.8 mm = 540 mm in all.
    longest = max(float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()) for line in lines)
    assert len(lines) < 45
    assert longest > 50


def test_nothing_wanted_gives_no_lines(film: Mesh) -> None:
    points, triangles = film
    field = MeshField(points_mm=points, triangles=triangles, q=np.zeros_like(points))
    assert dense_lines(field) == []
    assert tiling([], field).coverage == 1


def test_tiling_of_two_lines_is_that_counted_by_hand(film: Mesh) -> None:
    points, triangles = film
    field = MeshField(points_mm=points, triangles=triangles, q=director(np.zeros(len(points))))
    lines = [np.array([(-13.0, y), (13.0, y)]) for y in (0.0, 0.6)]
    found = tiling(lines, field)
    assert found.coverage == pytest.approx(1.4 / 18, abs=0.003)
    assert found.overlap == pytest.approx(0.2 / 18, abs=0.003)
    assert found.deviation_95_deg == 0
    assert found.length_mm == 52
    there_and_back = np.array([(-13.0, 0.0), (13.0, 0.0), (13.0, 0.6), (-13.0, 0.6)])
    assert tiling([there_and_back], field).overlap == pytest.approx(0.2 / 18, abs=0.003)


def test_a_ring_does_not_overlap_itself(film: Mesh) -> None:
    points, triangles = film
    turn = np.linspace(0, 2 * np.pi, 100)
    ring = 5 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    ring[-1] = ring[0]
    field = MeshField(points_mm=points, triangles=triangles, q=director(np.zeros(len(points))))
    found = tiling([ring], field)
    assert found.overlap == 0
    assert found.coverage * 24 * 18 == pytest.approx(2 * np.pi * 5 * 0.8, rel=0.01)


def test_wrong_arrays_are_told(film: Mesh) -> None:
    points, triangles = film
    with pytest.raises(InputError, match="shape"):
        MeshField(points_mm=points, triangles=triangles, q=np.zeros(len(points)))
    with pytest.raises(InputError, match="line_width_mm"):
        dense_lines(MeshField(points_mm=points, triangles=triangles, q=np.zeros_like(points)), line_width_mm=0)
