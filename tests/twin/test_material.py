"""The material: activation table, its inverse and its shift; moduli and weight."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from twin.material import ACTIVATION_TABLE, Material


def test_activation_is_zero_cold_and_one_hot():
    material = Material()
    assert material.activation(25.0) == 0.0
    assert material.activation(0.0) == 0.0
    assert material.activation(150.0) == pytest.approx(1.0, abs=1e-15)
    assert material.activation(119.0) < 1.0


@pytest.mark.parametrize(("temperature_c", "fraction"), ACTIVATION_TABLE)
def test_activation_meets_its_table(temperature_c, fraction):
    assert Material().activation(temperature_c) == pytest.approx(fraction, abs=1e-12)
    assert Material().temperature_c(fraction) == pytest.approx(temperature_c, abs=0.05)


def test_activation_rises_without_overshoot():
    fraction = Material().activation(np.linspace(0.0, 200.0, 2001))
    assert fraction.shape == (2001,)
    assert np.all(np.diff(fraction) >= 0.0)
    assert fraction.min() == 0.0
    assert fraction.max() == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize("transition_c", [60.0, 85.0, 100.0])
@given(fraction=st.floats(0.0, 1.0))
def test_temperature_is_the_inverse_of_activation(transition_c, fraction):
    material = Material(transition_c=transition_c)
    assert material.activation(material.temperature_c(fraction)) == pytest.approx(fraction, abs=1e-3)


def test_transition_temperature_shifts_the_table():
    temperature = np.linspace(25.0, 160.0, 50)
    lower = Material(transition_c=70.0)
    np.testing.assert_allclose(lower.activation(temperature - 15.0), Material().activation(temperature), atol=1e-12)
    assert lower.activation(95.0) > Material().activation(95.0)


def test_moduli_and_weight_by_hand():
    """E = 3 mu of an incompressible solid; 1200 kg/m3 at 9.81 m/s2 are 1.1772e-5 N/mm3."""
    material = Material(modulus_mpa=0.6)
    assert material.shear_modulus_mpa == pytest.approx(0.2)
    assert material.weight_n_mm3 == pytest.approx(1.1772e-5)
    # the load of the reference films: rho g H / mu at E = 0.5 MPa
    assert Material().weight_n_mm3 * 0.8 / Material().shear_modulus_mpa == pytest.approx(5.65e-5, rel=1e-3)
