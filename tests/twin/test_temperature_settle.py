"""Shape and temperature found together."""

import numpy as np
import pytest
from films import azimuthal, ellipse, film

from planner.errors import SolverError
from twin.equilibrium import Newton, rigid_pins
from twin.material import Material
from twin.predict import PredictOptions, film_loads
from twin.shell import Shell
from twin.temperature import TemperatureField, TemperatureGapModel, field_activation, settle_activation


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


def settled(field: TemperatureField, plate_c: float) -> tuple[np.ndarray, np.ndarray, Newton]:
    """Vertices [mm] and activation of a small dome on the plate, and its Newton method."""
    made = film(ellipse(10.0, 10.0), 1.4, contraction=0.15, direction=azimuthal)
    shell = Shell(made, loads=film_loads(made, PredictOptions(device="cpu")), device="cpu")
    newton = Newton(shell, rigid_pins(made.flat_mm, on_plate=True))
    shape = np.column_stack((made.flat_mm, 0.3 * np.cos(made.flat_mm / 8.0).prod(axis=1)))
    shell.set_activation(1.0)
    scale = shell.driving_force(shape)

    def follow(activation: np.ndarray) -> np.ndarray:
        nonlocal shape
        shell.set_activation(activation)
        shape = newton.solve(shape, force_scale=scale, tolerance=1e-7).vertices_mm
        return field_activation(field, Material(), made, shape, plate_c)

    activation = settle_activation(follow, field_activation(field, Material(), made, shape, plate_c))
    return shape, activation, newton


def test_dome_cools_itself_where_it_rises():
    field = TemperatureGapModel()
    shape, activation, newton = settled(field, 150.0)
    shell = newton.shell
    belongs = field_activation(field, Material(), shell.film, shape, 150.0)
    assert np.abs(belongs - activation).max() < 2e-4
    height = shape[:, 2][shell.film.triangles].mean(axis=1)
    assert np.all(np.diff(activation[np.argsort(height)]) < 1e-3)
    assert activation.max() == pytest.approx(1.0, abs=1e-6)
    shell.set_activation(1.0)
    scale = shell.driving_force(shape)
    hot = newton.solve(shape, force_scale=scale, tolerance=1e-7).vertices_mm
    assert 0.5 * hot[:, 2].max() < shape[:, 2].max() < hot[:, 2].max()
    newton.close()
