"""Reading curvature off shapes whose curvature is known."""

import numpy as np
import pytest
from films import ellipse
from scipy.spatial.transform import Rotation

from planner.target import mesh_outline
from twin.bending import principal_curvatures_per_mm

FLAT = mesh_outline(ellipse(2.0, 2.0), 0.2)[0]


def ellipsoid_like(first_per_mm: float, second_per_mm: float) -> np.ndarray:
    x, y = FLAT.T
    return np.column_stack((x, y, -0.5 * (first_per_mm * x**2 + second_per_mm * y**2)))


@pytest.mark.parametrize("curvatures", [(0.02, 0.05), (-0.03, 0.04), (-0.06, -0.01), (0.0, 0.05)])
def test_paraboloids_have_their_own_curvatures_wherever_they_lie(curvatures):
    shape = ellipsoid_like(*curvatures)
    np.testing.assert_allclose(principal_curvatures_per_mm(FLAT, shape), curvatures, atol=1e-12)
    turned = Rotation.from_rotvec([0.4, 2.0, -0.7]).apply(shape) + np.array([5.0, -3.0, 9.0])
    np.testing.assert_allclose(principal_curvatures_per_mm(FLAT, turned), curvatures, atol=1e-12)


def test_a_film_that_shrank_is_measured_as_it_is():
    np.testing.assert_allclose(principal_curvatures_per_mm(2.0 * FLAT, ellipsoid_like(0.02, 0.05)), (0.02, 0.05))


def test_cap_of_a_sphere():
    radius, arc = 10.0, np.hypot(*FLAT.T)
    unit = FLAT / np.maximum(arc, 1e-12)[:, None]
    cap = np.column_stack((radius * np.sin(arc / radius)[:, None] * unit, radius * np.cos(arc / radius)))
    np.testing.assert_allclose(principal_curvatures_per_mm(FLAT, cap), 0.1, rtol=0.01)
