"""From a Program or a field to a film: outline, areas, layers, what each triangle learned, sizes that are refused."""

import numpy as np
import pytest
import shapely
from films import ellipse, rectangle

from planner.alignment import AlignmentField
from planner.calibration import load_calibration, wide_strip
from planner.errors import InputError
from planner.plan import plan
from planner.program import Actuate, CreatedBy, Cut, Inputs, Layer, Pass, Program
from planner.program import Film as DepositedFilm
from planner.target import mesh_outline
from scenes.targets import ellipsoid_dome
from twin.bending import bending_radius_mm, principal_curvatures_per_mm
from twin.film import Film, FilmOptions, build_film, film_from_alignment, film_of_field
from twin.predict import PredictOptions, heat_film, predict, top_face

STACK = (0.2, 0.2, 0.2, 0.2)
STRONG = float(load_calibration().contraction(6.5, 0.5))


def program(cut_mm: np.ndarray, passes=(), *, thickness_mm=STACK, layers=(0, 1)) -> Program:
    """Program whose `layers` are scratched by the same passes and whose film is cut along a line."""
    reach = np.abs(cut_mm).max() + 10.0
    return Program(
        name="film",
        seed=0,
        created_by=CreatedBy(name="test", version="1"),
        inputs=Inputs(method="hand"),
        calibration=load_calibration().record,
        film=DepositedFilm(
            outline_mm=tuple(map(tuple, rectangle(2 * reach, 2 * reach).tolist())), layer_thickness_mm=thickness_mm
        ),
        layers=tuple(
            Layer.of(index, thickness, tuple(passes) if index in layers else ())
            for index, thickness in enumerate(thickness_mm)
        ),
        finish=(Cut(line_mm=tuple(map(tuple, cut_mm.tolist()))), Actuate()),
    )


def stroke(start, end) -> Pass:
    return Pass(points_mm=(start, end), speed_mm_s=(0.5,), load_g=(6.5,), side="convex")


def boundary(film: Film) -> shapely.LinearRing:
    """The one closed line of edges that belong to a single triangle."""
    edges = film.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    count = len(film.flat_mm)
    inner = np.isin(edges[:, 0] * count + edges[:, 1], edges[:, 1] * count + edges[:, 0])
    lines = shapely.linestrings(film.flat_mm[edges[~inner]])
    merged = shapely.line_merge(shapely.union_all(lines))
    assert merged.is_ring
    return shapely.LinearRing(merged.coords)


def bean() -> np.ndarray:
    """A smooth outline with a hollow side [mm]."""
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    radius = 8.0 + 2.0 * np.cos(2 * angle) + 1.0 * np.sin(3 * angle)
    return np.column_stack((radius * np.cos(angle), radius * np.sin(angle)))


@pytest.mark.parametrize("cut_mm", [ellipse(10, 10, 360), bean(), rectangle(12, 7)], ids=["disc", "bean", "rectangle"])
def test_mesh_follows_the_cut_line_smoothly(cut_mm):
    mesh_mm = 0.6
    made = build_film(program(cut_mm), FilmOptions(mesh_mm=mesh_mm))
    line, border = shapely.LinearRing(cut_mm), boundary(made)
    corners = shapely.points(np.asarray(border.coords))
    # vertices on the line, edges as near as chords of its curves can be: h^2 / 8 R, R above 2 mm
    assert shapely.distance(corners, line).max() < 0.01
    assert shapely.hausdorff_distance(border, line, densify=0.2) < mesh_mm**2 / (8 * 2.0)
    turn = np.diff(np.unwrap(np.arctan2(*np.diff(np.asarray(border.coords), axis=0).T[::-1])))
    assert len(cut_mm) == 4 or np.abs(turn).max() < 0.5
    assert made.area_mm2.sum() == pytest.approx(shapely.Polygon(cut_mm).area, rel=0.003)


def test_areas_of_a_square_of_two_triangles_by_hand():
    made = film_from_alignment(
        np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]),
        np.array([[0, 1, 2], [0, 2, 3]]),
        np.zeros((4, 2, 2)),
        layer_thickness_mm=np.array(STACK),
    )
    np.testing.assert_allclose(made.area_mm2, 2.0)
    np.testing.assert_allclose(made.vertex_area_mm2, np.array([4, 2, 4, 2]) / 3)
    assert made.thickness_mm == pytest.approx(0.8)
    assert not made.contraction.any()


def test_all_triangles_are_counter_clockwise_and_of_one_size():
    area = build_film(program(bean()), FilmOptions(mesh_mm=0.6)).area_mm2
    regular = np.sqrt(3) / 4 * 0.6**2
    assert area.min() > 0.2 * regular
    assert area.max() < 2.5 * regular
    assert np.median(area) == pytest.approx(regular, rel=0.1)


def test_layers_learn_what_was_scratched_into_them():
    lines = [stroke((-9.0, y), (9.0, y)) for y in np.arange(-6.4, 6.5, 0.8)]
    made = build_film(program(rectangle(12, 10), lines, layers=(1, 2)), FilmOptions(mesh_mm=1.0))
    np.testing.assert_allclose(made.contraction[[1, 2]], STRONG, rtol=1e-6)
    np.testing.assert_allclose(np.sin(made.director_rad[[1, 2]]), 0.0, atol=1e-6)
    assert not made.contraction[[0, 3]].any()
    np.testing.assert_array_equal(made.modulus_ratio, 1.0)


def test_triangles_average_a_single_line():
    """A line 0.8 mm wide and 4 mm long in a film of coarse triangles: the sum over the area is kept."""
    made = build_film(program(rectangle(12, 12), [stroke((-2.0, 0.03), (2.0, 0.03))]), FilmOptions(mesh_mm=1.0))
    painted = float(made.contraction[0] @ made.area_mm2)
    assert painted == pytest.approx(STRONG * (4.0 * 0.8 + np.pi * 0.4**2), rel=0.05)
    assert 0 < np.count_nonzero(made.contraction[0] > 1e-9) < 0.3 * len(made.triangles)
    assert made.contraction[0].max() < STRONG


@pytest.mark.parametrize(
    ("mesh_mm", "told"),
    [
        (0.01, r"found 0\.01 mm, allowed are 0\.05 to 5 mm"),
        (7.0, r"found 7 mm, allowed are 0\.05 to 5 mm"),
        (float("nan"), "found nan mm"),
        (-1.0, "found -1 mm"),
        (4.0, r"4 mm leaves about \d triangles .* use --mesh-mm"),
    ],
)
def test_mesh_sizes_that_make_no_sense_are_refused(mesh_mm, told):
    with pytest.raises(InputError, match=told):
        build_film(program(rectangle(6, 5)), FilmOptions(mesh_mm=mesh_mm))


def test_mesh_that_needs_more_memory_than_there_is_is_refused_with_one_that_fits(monkeypatch):
    monkeypatch.setattr("twin.film.build._free_memory", lambda: 50e6)
    with pytest.raises(
        InputError, match=r"about 1\.7 GB of memory, free are 0\.1 GB; use --mesh-mm (\d\.\d\d)"
    ) as told:
        build_film(program(rectangle(60, 40)), FilmOptions(mesh_mm=0.2))
    allowed = float(str(told.value).split("--mesh-mm ")[1].split()[0])
    assert len(build_film(program(rectangle(60, 40)), FilmOptions(mesh_mm=allowed + 0.01)).triangles) * 12_000 < 55e6


@pytest.mark.parametrize(
    ("thickness_mm", "aligned"),
    [((0.3, 0.3), (0,)), ((0.3, 0.1, 0.2), (0,)), ((0.1, 0.15, 0.2, 0.1, 0.2), (0, 1)), ((0.2, 0.4, 0.1), (2,))],
    ids=["two", "three", "five", "the top one of three"],
)
def test_strips_of_any_stack_bend_as_the_wide_strip_of_that_stack(thickness_mm, aligned):
    contraction = 0.12
    flat, triangles = mesh_outline(rectangle(10.0, 20.0), 0.8)
    q = np.zeros((len(thickness_mm), len(triangles), 2))
    q[list(aligned), :, 0] = contraction
    made = film_from_alignment(flat, triangles, q, layer_thickness_mm=np.array(thickness_mm))
    radius = bending_radius_mm(heat_film(made, PredictOptions(support="free", device="cpu")))
    assert radius == pytest.approx(float(wide_strip(contraction, thickness_mm, aligned)[0]), rel=0.03)


@pytest.mark.parametrize("thickness_mm", [(0.2, 0.25, 0.15), (0.15, 0.1, 0.2, 0.1, 0.25)], ids=["three", "five"])
def test_plans_of_other_stacks_predict(thickness_mm):
    target = ellipsoid_dome(radius_mm=8.0, height_mm=4.0, cut=0.9)
    made = plan(target, layer_thickness_mm=thickness_mm).program
    middle = len(thickness_mm) // 2
    assert [bool(layer.passes) for layer in made.layers] == [index < middle for index in range(len(thickness_mm))]
    options = PredictOptions(film=FilmOptions(mesh_mm=1.0), support="free", device="cpu")
    shape = predict(made, options)
    np.testing.assert_array_equal(shape.film.layer_thickness_mm, thickness_mm)
    assert shape.stable
    assert np.all(principal_curvatures_per_mm(shape.film, shape.hot_mm) > 0.02)


def test_film_of_a_field_learns_the_field_and_nothing_beyond_it():
    x, y = (values.ravel() for values in np.meshgrid(np.arange(-5, 0.01, 0.1), np.arange(-5, 5.01, 0.1)))
    angle = 0.3 + 0.1 * y
    vector = 0.2 * np.column_stack((np.cos(2 * angle), np.sin(2 * angle)))
    q = np.stack((vector, vector, 0 * vector, -vector))
    field = AlignmentField(points_mm=np.column_stack((x, y)), q=q)
    made = film_of_field(field, rectangle(9.0, 9.0), 0.5, layer_thickness_mm=np.array(STACK))
    centre = made.flat_mm[made.triangles].mean(axis=1)
    inside, beyond = centre[:, 0] < -0.3, centre[:, 0] > 0.6
    np.testing.assert_allclose(made.contraction[[0, 1, 3]][:, inside], 0.2, rtol=0.01)
    wanted = 0.3 + 0.1 * centre[:, 1]
    np.testing.assert_allclose(np.sin(made.director_rad[0] - wanted)[inside], 0.0, atol=0.01)
    np.testing.assert_allclose(np.cos(made.director_rad[3] - wanted)[inside], 0.0, atol=0.01)
    assert not made.contraction[2].any()
    assert not made.contraction[:, beyond].any()
    with pytest.raises(InputError, match="mesh size"):
        film_of_field(field, rectangle(9.0, 9.0), 20.0, layer_thickness_mm=np.array(STACK))


def test_top_face_of_a_flat_film_is_half_its_thickness_up():
    flat, triangles = mesh_outline(ellipse(4.0, 3.0), 0.8)
    made = film_from_alignment(flat, triangles, np.zeros((4, len(triangles), 2)), layer_thickness_mm=np.array(STACK))
    middle = np.column_stack((flat, np.full(len(flat), 2.0)))
    top = top_face(made, middle, np.full(len(triangles), 0.4))
    np.testing.assert_allclose(top, middle + np.array([0.0, 0.0, 0.4]), atol=1e-15)
    # upright on its edge, what was the top points sideways
    upright = middle[:, [2, 0, 1]]
    sideways = top_face(made, upright, np.full(len(triangles), 0.4))
    np.testing.assert_allclose(sideways, upright + np.array([0.4, 0.0, 0.0]), atol=1e-15)


def test_top_face_of_a_contracted_film_lies_at_its_hot_thickness():
    """lambda = 0.64 in all layers: the film is 0.8 / 0.8 = 1 mm thick when hot."""
    flat, triangles = mesh_outline(rectangle(5.0, 4.0), 1.0)
    q = np.zeros((4, len(triangles), 2))
    q[..., 0] = 0.36
    made = film_from_alignment(flat, triangles, q, layer_thickness_mm=np.array(STACK))
    shape = heat_film(made, PredictOptions(support="free", device="cpu"))
    assert np.linalg.norm(shape.top_mm - shape.hot_mm, axis=1) == pytest.approx(0.5, rel=1e-9)
    assert np.ptp(shape.top_mm[:, 2]) < 1e-6


def test_a_film_of_alignment_vectors_has_them():
    flat, triangles = mesh_outline(np.array([(0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0)]), 1.0)
    q = 0.1 * np.random.default_rng(0).normal(size=(4, len(triangles), 2))
    film = film_from_alignment(flat, triangles, q, layer_thickness_mm=np.array(STACK))
    np.testing.assert_allclose(film.alignment, q, atol=1e-15)
