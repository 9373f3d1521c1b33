"""Shape and temperature found together."""

import numpy as np
import pytest
from films import azimuthal, ellipse, film

from planner.errors import SolverError
from twin.cycle import rigid_distance_mm
from twin.equilibrium import Newton, heat, rigid_pins
from twin.film import Film
from twin.material import Material
from twin.predict import PredictOptions, film_loads, heat_film
from twin.shell import Shell
from twin.temperature import (
    FieldNewton,
    FieldShell,
    TemperatureField,
    TemperatureFile,
    TemperatureGapModel,
    plate_temperature_c,
    settle_activation,
)


def test_what_does_not_depend_on_the_shape_is_found_at_once():
    calls = []

    def follow(activation: np.ndarray) -> np.ndarray:
        calls.append(activation)
        return np.full(5, 0.7)

    np.testing.assert_array_equal(settle_activation(follow, np.full(5, 0.7)), np.full(5, 0.7))
    assert len(calls) == 1


def test_steep_opposition_settles_where_taking_turns_swings_away():
    """The answer falls by 3 where the activation rises by 1: a_k = 0.4 + c_k (0.5 - a_k), so a_k (1 + c_k) is known."""
    steepness = np.linspace(0.5, 3.0, 20)

    def follow(activation: np.ndarray) -> np.ndarray:
        return np.clip(0.4 + steepness * (0.5 - activation), 0.0, 1.0)

    turns = np.full(20, 0.6)
    for _ in range(50):
        turns = follow(turns)
    exact = (0.4 + 0.5 * steepness) / (1.0 + steepness)
    assert np.abs(turns - exact).max() > 0.3
    np.testing.assert_allclose(settle_activation(follow, np.full(20, 0.6)), exact, atol=1e-4)


def test_activation_stays_between_cold_and_hot():
    found = settle_activation(
        lambda activation: np.clip(3.0 - 5.0 * activation.mean() + activation, 0.0, 1.0), np.ones(3)
    )
    np.testing.assert_allclose(found, 0.6, atol=1e-4)


def test_what_never_settles_is_said():
    with pytest.raises(SolverError, match=r"do not settle in \d+ rounds"):
        settle_activation(lambda activation: np.where(activation < 0.5, 1.0, 0.0), np.full(4, 0.2))


def heated(made: Film, field: TemperatureField, *, down: bool = False, temperature_c: float = 150.0):
    """States of a ramp on the plate and back, and its shell at the last temperature."""
    loads = film_loads(made, PredictOptions(device="cpu"))
    shell = FieldShell(made, field=field, material=Material(), temperature_c=temperature_c, loads=loads)
    newton = FieldNewton(shell, rigid_pins(made.flat_mm, on_plate=True))
    states = heat(newton, [1.0, 0.0] if down else 1.0, rng=np.random.default_rng(0))
    newton.close()
    return states, shell


DOME = film(ellipse(10.0, 10.0), 1.4, contraction=0.15, direction=azimuthal)


def test_dome_cools_itself_where_it_rises():
    states, shell = heated(DOME, TemperatureGapModel())
    shape = states[-1].equilibrium.vertices_mm
    assert shell.plate_c == pytest.approx(150.0)
    temperature = TemperatureGapModel().temperature_c(DOME, shape, 150.0)
    activation = shell.activation_of(shape)
    np.testing.assert_allclose(activation, Material().activation(temperature))
    height = shape[:, 2][DOME.triangles].mean(axis=1)
    assert np.all(np.diff(temperature[np.argsort(height)]) <= 0.0)
    assert temperature.min() < 110.0
    assert temperature.max() > 138.0
    hot = heat_film(DOME, PredictOptions(device="cpu")).hot_mm
    assert 0.5 * hot[:, 2].max() < shape[:, 2].max() < 0.95 * hot[:, 2].max()
    # the shape is in equilibrium with its own temperatures: another solve does not move it
    newton = Newton(shell, rigid_pins(DOME.flat_mm, on_plate=True))
    shell.set_activation(activation)
    again = newton.solve(shape, force_scale=shell.driving_force(shape), tolerance=1e-8)
    newton.close()
    assert np.abs(again.vertices_mm - shape).max() < 0.01


def test_dome_comes_back_flat():
    states, _ = heated(DOME, TemperatureGapModel(), down=True)
    cold = states[-1].equilibrium.vertices_mm
    assert np.ptp(cold[:, 2]) < 1e-6
    assert len(states) >= 7


def test_warm_plate_everywhere_is_the_plain_ramp():
    """A file that says 150 C everywhere: another way there, the same shape."""
    grid = np.array([-20.0, 20.0])
    field = TemperatureFile(source="warm.npz", x_mm=grid, y_mm=grid, grid_c=np.full((2, 2), 150.0))
    found = heated(DOME, field)[0][-1].equilibrium
    plain = heat_film(DOME, PredictOptions(device="cpu"))
    assert rigid_distance_mm(found.vertices_mm, plain.hot_mm) < 1e-4


def test_plate_warms_from_the_room_to_the_end_in_steps_of_both_kinds():
    share = np.linspace(0.0, 1.0, 101)
    plate = plate_temperature_c(share, Material(), 150.0)
    assert (plate[0], plate[-1]) == pytest.approx((25.0, 150.0))
    assert np.all(np.diff(plate) > 0.0)
    both = 0.5 * (plate - 25.0) / 125.0 + 0.5 * Material().activation(plate)
    np.testing.assert_allclose(both, share, atol=1e-3)
    np.testing.assert_allclose(plate_temperature_c(share, Material(), 25.0), 25.0)


def test_field_newton_refuses_a_plain_shell():
    newton = FieldNewton(Shell(DOME, device="cpu"), rigid_pins(DOME.flat_mm, on_plate=False))
    with pytest.raises(TypeError, match="needs a FieldShell"):
        newton.solve(np.zeros((len(DOME.flat_mm), 3)), force_scale=1.0, tolerance=1e-6)
    newton.close()
