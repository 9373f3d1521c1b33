import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from planner.calibration import contraction_for_radius, radius_for_contraction, wide_strip

FOUR = (0.2, 0.2, 0.2, 0.2)
CONTRACTION = np.array([2, 4, 6, 8, 10, 15, 20, 25, 30, 35, 40, 45]) / 100
# An independent finite-strain calculation of the same strip, with the true change of thickness at every
# height.
RADIUS_MM = np.array([35.4, 17.6, 11.7, 8.73, 6.96, 4.61, 3.44, 2.75, 2.30, 1.98, 1.75, 1.58])
ALONG = np.array([0.990, 0.980, 0.970, 0.960, 0.950, 0.924, 0.898, 0.871, 0.844, 0.816, 0.786, 0.754])
ACROSS = np.array([1.005, 1.010, 1.016, 1.021, 1.027, 1.041, 1.057, 1.074, 1.092, 1.113, 1.135, 1.160])


def test_it_agrees_with_the_independent_table() -> None:
    radius, along, across = wide_strip(CONTRACTION, FOUR, (0, 1))
    mild = CONTRACTION <= 0.30
    np.testing.assert_allclose(radius[mild], RADIUS_MM[mild], rtol=0.0035)
    np.testing.assert_allclose(radius, RADIUS_MM, rtol=0.017)
    np.testing.assert_allclose(along[mild], ALONG[mild], atol=0.003)
    np.testing.assert_allclose(along, ALONG, atol=0.009)
    np.testing.assert_allclose(across, ACROSS, atol=0.0006)


def test_small_strain_is_the_closed_form() -> None:
    radius, along, across = wide_strip(1e-4, FOUR, (0, 1))
    assert 0.8 / radius / 1e-4 == pytest.approx(1.125, rel=1e-3)
    assert along == pytest.approx(1 - 0.5e-4, abs=1e-8)
    assert across == pytest.approx(1 + 0.25e-4, abs=1e-8)


def test_the_sign_says_which_way() -> None:
    up, down = wide_strip(0.2, FOUR, (0, 1))[0], wide_strip(0.2, FOUR, (2, 3))[0]
    assert up > 0
    assert down == pytest.approx(-up)
    assert np.isinf(wide_strip(0.0, FOUR, (0, 1))[0])


def test_all_layers_contract_without_bending() -> None:
    radius, along, across = wide_strip(0.3, FOUR, (0, 1, 2, 3))
    assert abs(radius) > 1e6
    assert along == pytest.approx(0.7)
    assert across == pytest.approx(0.7**-0.5)


def test_the_layers_may_be_cut_finer() -> None:
    # Two Gauss points a layer: the energy is not polynomial in z, so finer layers only come close.
    coarse = wide_strip(0.2, (0.4, 0.4), (0,))[0]
    fine = wide_strip(0.2, (0.1,) * 8, (0, 1, 2, 3))[0]
    assert coarse == pytest.approx(fine, rel=0.005)


def test_a_general_minimiser_finds_the_same() -> None:
    thickness, e = (0.1, 0.3, 0.2), 0.25
    stretch = np.array([1 - e, 1, 1])
    hot = np.array(thickness) * stretch**-0.5
    # The flat mid-plane, at 0.3 mm, lies in the second layer, which does not swell.
    bottom = -(hot[0] + 0.2)
    edges = bottom + np.concatenate([[0], np.cumsum(hot)])

    def energy(unknown: np.ndarray) -> float:
        p, q, k = unknown
        total = 0.0
        for i in range(3):
            for spot in (-1, 1):
                z = (edges[i] + edges[i + 1]) / 2 + spot * hot[i] / np.sqrt(12)
                u, a, b = p - z * k, stretch[i] ** 2, 1 / stretch[i]
                total += thickness[i] / 2 * (u**2 / a + q**2 / b + a * b / (u * q) ** 2)
        return total

    best = minimize(energy, [1, 1, 0], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-14})
    radius, along, across = wide_strip(e, thickness, (0,))
    assert radius == pytest.approx(-best.x[0] / best.x[2], rel=1e-5)
    assert (along, across) == pytest.approx(tuple(best.x[:2]), rel=1e-6)


@settings(max_examples=40, deadline=None)
@given(st.floats(0.005, 0.59))
def test_the_inverse_undoes_it(contraction: float) -> None:
    radius = wide_strip(contraction, FOUR, (0, 1))[0]
    assert contraction_for_radius(radius, FOUR, (0, 1)) == pytest.approx(contraction, rel=1e-5)
    assert radius_for_contraction(contraction, FOUR, (0, 1)) == pytest.approx(radius, rel=1e-5)


def test_what_cannot_be_reached_is_refused() -> None:
    with pytest.raises(ValueError, match="cannot be reached"):
        contraction_for_radius(0.5, FOUR, (0, 1))
    with pytest.raises(ValueError, match="does not bend"):
        contraction_for_radius(5.0, FOUR, (0, 1, 2, 3))
    assert contraction_for_radius(np.inf, FOUR, (0, 1)) == 0
