"""Strips from narrow to wide against their limits."""

import numpy as np
import pytest

from planner.calibration import contraction_for_radius, curvature_at_width, radius_for_contraction, width_factor

STACK = ((0.2,) * 4, (0, 1))


def test_narrow_and_wide_limits():
    assert width_factor(1 / 10, 0.8, 0.5) == pytest.approx(0.75, abs=1e-4)
    assert width_factor(1 / 10, 0.8, 5000.0) == pytest.approx(1.0, abs=0.01)


def test_the_factor_rises_with_width_from_3_to_4_to_1():
    factors = [float(width_factor(1 / 10, 0.8, width)) for width in np.geomspace(0.5, 500, 60)]
    assert np.all(np.diff(factors) > -1e-9)


def test_curvature_at_width_inverts_the_factor():
    curvature = np.geomspace(0.01, 0.5, 9)
    wide = curvature * width_factor(curvature, 0.8, 7.0)
    np.testing.assert_allclose(curvature_at_width(wide, 0.8, 7.0), curvature, rtol=1e-9)


def test_radius_and_contraction_of_a_narrow_strip_invert_each_other():
    e = np.array([0.02, 0.1, 0.3])
    radius = radius_for_contraction(e, *STACK, 4.0)
    assert np.all(radius < radius_for_contraction(e, *STACK))
    np.testing.assert_allclose(contraction_for_radius(radius, *STACK, 4.0), e, rtol=1e-4)
