import numpy as np
import pytest

from planner.target import mesh_outline
from twin.equilibrium import heat
from twin.film import film_from_alignment
from twin.inverse.sensitivity import Sensitivity
from twin.predict import PredictOptions, open_newton


@pytest.mark.parametrize("support", ["free", "plate"])
def test_gradient_through_the_equilibrium_is_that_of_differences(support):
    """Of a random linear function of the vertices, with contact active on the plate."""
    rng = np.random.default_rng(0)
    flat, triangles = mesh_outline(np.array([(-6.0, -4.0), (6.0, -4.0), (6.0, 4.0), (-6.0, 4.0)]), 1.2)
    q = np.zeros((4, len(triangles), 2))
    q[:, :, 0] = np.array([0.08, 0.06, 0.0, -0.05])[:, None] + 0.01 * flat[triangles].mean(axis=1)[:, 0] / 6.0
    q[2, :, 1] = 0.03

    def film(alignment):
        return film_from_alignment(flat, triangles, alignment, layer_thickness_mm=np.full(4, 0.2))

    newton = open_newton(film(q), PredictOptions(support=support))
    x = heat(newton, 1.0, rng=np.random.default_rng(0))[-1].equilibrium.vertices_mm
    scale = newton.shell.driving_force(np.column_stack((flat, np.zeros(len(flat)))))

    def settled(alignment):
        newton.shell.teach(film(alignment), 1.0)
        return newton.solve(x, force_scale=scale, tolerance=1e-13).vertices_mm

    x = settled(q)
    assert (x[:, 2] < 0.01).any() or support == "free"
    sensitivity = Sensitivity(newton)
    assert sensitivity.at(x, q, 1.0)
    weight, dq = rng.normal(size=x.shape), 0.01 * rng.normal(size=q.shape)
    gradient = float((sensitivity.pull(weight) * dq).sum())
    assert float((sensitivity.push(dq) * weight).sum()) == pytest.approx(gradient, rel=1e-9)
    # many at once are those one by one
    for found, one in zip(sensitivity.push(np.stack((dq, 2.0 * q))), (dq, 2.0 * q), strict=True):
        np.testing.assert_allclose(found, sensitivity.push(one), rtol=1e-9, atol=1e-12)
    for found, one in zip(sensitivity.pull(np.stack((weight, x))), (weight, x), strict=True):
        np.testing.assert_allclose(found, sensitivity.pull(one), rtol=1e-9, atol=1e-12)

    def difference(step):
        return float(((settled(q + step * dq) - settled(q - step * dq)) * weight).sum()) / (2.0 * step)

    coarse, fine = difference(1e-2), difference(5e-3)
    assert (4.0 * fine - coarse) / 3.0 == pytest.approx(gradient, rel=1e-6)
    newton.close()
