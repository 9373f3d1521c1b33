"""Temperature fields: uniform, lifted off the plate, from a file; and the activation that follows."""

import numpy as np
import pytest
from films import film, rectangle
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from planner.errors import InputError
from twin.material import Material
from twin.temperature import (
    TemperatureFile,
    TemperatureGapModel,
    TemperatureUniform,
    field_activation,
    gap_temperature_c,
    load_temperature_file,
)

FILM = film(rectangle(12.0, 8.0), 1.0)


def at_height(z_mm) -> np.ndarray:
    """The film lying level or tilted at heights [mm], a number or shape [n]."""
    return np.column_stack((FILM.flat_mm, np.broadcast_to(np.asarray(z_mm, dtype=float), len(FILM.flat_mm))))


def saved(path, **arrays):
    np.savez(path, **arrays)
    return path


def test_uniform_is_the_plate_everywhere():
    found = TemperatureUniform().temperature_c(FILM, at_height(7.0), 140.0)
    np.testing.assert_array_equal(found, np.full(len(FILM.triangles), 140.0))


def test_film_on_the_plate_has_its_temperature_exactly():
    assert gap_temperature_c(0.0, 150.0, convection_w_m2k=5.0) == pytest.approx(150.0, abs=1e-9)
    found = TemperatureGapModel().temperature_c(FILM, at_height(-6e-5), 150.0)
    np.testing.assert_allclose(found, 150.0, atol=1e-9)


def test_gap_model_meets_the_figures_it_states():
    gaps = np.array([0.0, 0.5, 1.0, 2.0, 5.0, 10.0])
    for convection, stated in (
        (5.0, (150, 131, 121, 111, 100, 94)),
        (11.0, (150, 125, 113, 101, 88, 82)),
        (25.0, (150, 113, 98, 84, 70, 64)),
    ):
        np.testing.assert_allclose(gap_temperature_c(gaps, 150.0, convection_w_m2k=convection), stated, atol=0.6)


def test_default_lies_inside_what_is_expected_of_lifted_films():
    at_5_mm, at_10_mm = gap_temperature_c([5.0, 10.0], 150.0, convection_w_m2k=TemperatureGapModel().convection_w_m2k)
    assert 88.0 < at_5_mm < 118.0
    assert 81.0 < at_10_mm < 115.0


@settings(max_examples=60, deadline=None)
@given(
    gap=st.floats(1e-3, 50.0),
    plate=st.floats(26.0, 200.0),
    convection=st.floats(0.0, 50.0),
)
def test_heat_in_is_heat_out(gap, plate, convection):
    """The balance, written in fluxes [W/m^2] and solved by bisection."""
    s, e = 5.670374e-8, 0.95

    def surplus(t: float) -> float:
        up = 0.033 / (1e-3 * gap) * (plate - t) + s / (2 / e - 1) * ((plate + 273.15) ** 4 - (t + 273.15) ** 4)
        return up - convection * (t - 25.0) - s * e * ((t + 273.15) ** 4 - 298.15**4)

    found = float(gap_temperature_c(gap, plate, convection_w_m2k=convection))
    assert found == pytest.approx(brentq(surplus, 24.0, plate + 1.0, xtol=1e-12), abs=1e-7)
    assert 25.0 < found < plate


def test_gap_model_falls_smoothly_with_height():
    height = np.linspace(-0.05, 20.0, 40_101)
    field = TemperatureGapModel()
    one = film(rectangle(3.0, 3.0), 1.0)
    corners = np.zeros((len(one.flat_mm), 3))
    found = []
    for z in height[:400]:
        corners[:, 2] = z
        found.append(field.temperature_c(one, corners, 150.0)[0])
    found = np.array(found)
    assert np.all(np.diff(found) <= 1e-12)
    # no jump of the slope: it changes by little from one hundredth of the contact height to the next
    slope = np.diff(found) / np.diff(height[:400])
    assert np.abs(np.diff(slope)).max() < 0.02 * np.abs(slope).max()
    assert slope.min() < -40.0
    far = gap_temperature_c(height[height >= 0.0], 150.0, convection_w_m2k=5.0)
    assert np.all(np.diff(far) < 0.0)


def test_tilted_film_is_coldest_where_highest():
    found = TemperatureGapModel().temperature_c(FILM, at_height(FILM.flat_mm[:, 0] + 6.0), 150.0)
    height = FILM.flat_mm[FILM.triangles].mean(axis=1)[:, 0] + 6.0
    order = np.argsort(height)
    assert np.all(np.diff(found[order]) <= 1e-9)
    assert np.ptp(found) > 30.0


def test_cold_plate_leaves_the_room_temperature():
    np.testing.assert_allclose(gap_temperature_c([0.0, 1.0, 10.0], 25.0, convection_w_m2k=5.0), 25.0, atol=1e-9)


@pytest.mark.parametrize("convection", [-1.0, 101.0, float("nan")])
def test_gap_model_refuses_impossible_convection(convection):
    with pytest.raises(InputError, match=r"convection_w_m2k is .*allowed are 0 to 100"):
        TemperatureGapModel(convection_w_m2k=convection)


def test_activation_follows_the_temperature():
    material = Material()
    on_plate = field_activation(TemperatureGapModel(), material, FILM, at_height(0.0), 150.0)
    np.testing.assert_allclose(on_plate, 1.0, atol=1e-12)
    lifted = field_activation(TemperatureGapModel(), material, FILM, at_height(5.0), 150.0)
    np.testing.assert_allclose(lifted, material.activation(99.6), atol=0.01)
    np.testing.assert_allclose(field_activation(TemperatureUniform(), material, FILM, at_height(5.0), 25.0), 0.0)


def test_file_is_interpolated_at_the_flat_centre(tmp_path):
    x, y = np.linspace(-7.0, 7.0, 8), np.linspace(-5.0, 5.0, 5)
    grid = 100.0 + 3.0 * x[None, :] - 2.0 * y[:, None]
    field = load_temperature_file(saved(tmp_path / "t.npz", x_mm=x, y_mm=y, temperature_c=grid))
    centre = FILM.flat_mm[FILM.triangles].mean(axis=1)
    wanted = 100.0 + 3.0 * centre[:, 0] - 2.0 * centre[:, 1]
    np.testing.assert_allclose(field.temperature_c(FILM, at_height(3.0), 150.0), wanted, rtol=1e-12)
    np.testing.assert_allclose(field.temperature_c(FILM, at_height(0.0), 25.0), 25.0, rtol=1e-12)
    halfway = field.temperature_c(FILM, at_height(0.0), 87.5)
    np.testing.assert_allclose(halfway, 0.5 * (25.0 + wanted), rtol=1e-12)


def test_file_may_name_its_own_plate_temperature(tmp_path):
    grid = np.full((2, 2), 90.0)
    path = saved(tmp_path / "t.npz", x_mm=[-9.0, 9.0], y_mm=[-9.0, 9.0], temperature_c=grid, plate_c=120)
    found = load_temperature_file(path).temperature_c(FILM, at_height(0.0), 120.0)
    np.testing.assert_allclose(found, 90.0)


def test_film_beyond_the_file_is_refused():
    field = TemperatureFile(
        source="small.npz", x_mm=np.array([-9.0, 2.0]), y_mm=np.array([-1.0, 1.0]), grid_c=np.full((2, 2), 100.0)
    )
    with pytest.raises(InputError) as caught:
        field.temperature_c(FILM, at_height(0.0), 150.0)
    assert len(caught.value.problems) == 2
    assert "small.npz: x_mm spans -9 to 2 mm" in caught.value.problems[0]


GOOD = {"x_mm": [0.0, 1.0, 2.0], "y_mm": [0.0, 1.0], "temperature_c": np.full((2, 3), 90.0)}


@pytest.mark.parametrize(
    ("change", "sentences"),
    [
        ({"temperature_c": None}, ["temperature_c is missing (the file has x_mm, y_mm)"]),
        ({"x_mm": ["a", "b", "c"]}, ["x_mm is of type <U1; give real numbers"]),
        ({"x_mm": [0.0, 2.0, 1.0]}, ["x_mm has the shape [3] and must be ascending"]),
        ({"y_mm": [0.0, np.nan]}, ["y_mm has the shape [2] and must be ascending finite"]),
        ({"temperature_c": np.full((3, 2), 90.0)}, ["temperature_c has the shape [3, 2], allowed is one row"]),
        ({"temperature_c": np.full((2, 3), 400.0)}, ["6 of 6 values outside of 0 to 250 C (the first is 400)"]),
        ({"temperature_c": [[90, 90, np.nan]] * 2}, ["2 of 6 values outside of 0 to 250 C (the first is nan)"]),
        ({"plate_c": 20.0}, ["plate_c is 20.0, allowed is one number above 25"]),
        ({"x_mm": [[0.0]], "plate_c": [1.0, 2.0]}, ["x_mm has", "temperature_c has", "plate_c is [1.0, 2.0]"]),
    ],
)
def test_bad_files_are_told_apart(tmp_path, change, sentences):
    arrays = {key: value for key, value in {**GOOD, **change}.items() if value is not None}
    with pytest.raises(InputError) as caught:
        load_temperature_file(saved(tmp_path / "t.npz", **arrays))
    assert len(caught.value.problems) == len(sentences)
    for problem, sentence in zip(caught.value.problems, sentences, strict=True):
        assert problem.startswith(f"temperature file {tmp_path / 't.npz'}: ")
        assert sentence in problem


@pytest.mark.parametrize("content", [None, b"", b"no archive"])
def test_what_is_no_file_of_arrays_is_refused(tmp_path, content):
    path = tmp_path / "t.npz"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=r"cannot be read as \.npz"):
        load_temperature_file(path)


def test_a_single_array_is_refused(tmp_path):
    np.save(tmp_path / "t.npy", np.ones((3, 3)))
    with pytest.raises(InputError, match=r"t\.npy: cannot be read as \.npz"):
        load_temperature_file(tmp_path / "t.npy")
