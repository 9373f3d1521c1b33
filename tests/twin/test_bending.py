"""Reading curvature off shapes whose curvature is known."""

import dataclasses

import numpy as np
import pytest
from films import ellipse, film
from scipy.spatial.transform import Rotation

from twin.bending import principal_curvatures_per_mm

DISC = film(ellipse(2.0, 2.0), 0.2)


def paraboloid(first_per_mm: float, second_per_mm: float) -> np.ndarray:
    x, y = DISC.flat_mm.T
    return np.column_stack((x, y, -0.5 * (first_per_mm * x**2 + second_per_mm * y**2)))


@pytest.mark.parametrize("curvatures", [(0.02, 0.05), (-0.03, 0.04), (-0.06, -0.01), (0.0, 0.05)])
def test_paraboloids_have_their_own_curvatures_wherever_they_lie(curvatures):
    shape = paraboloid(*curvatures)
    np.testing.assert_allclose(principal_curvatures_per_mm(DISC, shape), curvatures, atol=1e-5)
    turned = Rotation.from_rotvec([0.4, 2.0, -0.7]).apply(shape) + np.array([5.0, -3.0, 9.0])
    np.testing.assert_allclose(principal_curvatures_per_mm(DISC, turned), curvatures, atol=1e-5)


def test_a_film_that_shrank_is_measured_as_it_is():
    larger = dataclasses.replace(DISC, flat_mm=2.0 * DISC.flat_mm)
    np.testing.assert_allclose(principal_curvatures_per_mm(larger, paraboloid(0.02, 0.05)), (0.02, 0.05), rtol=1e-4)


def test_cap_of_a_sphere():
    radius, arc = 10.0, np.hypot(*DISC.flat_mm.T)
    unit = DISC.flat_mm / np.maximum(arc, 1e-12)[:, None]
    cap = np.column_stack((radius * np.sin(arc / radius)[:, None] * unit, radius * np.cos(arc / radius)))
    np.testing.assert_allclose(principal_curvatures_per_mm(DISC, cap), 0.1, rtol=0.01)
