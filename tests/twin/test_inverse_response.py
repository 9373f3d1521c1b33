import numpy as np
import pytest

from planner.target import mesh_outline
from twin.film import film_from_alignment
from twin.inverse.forms import edge_forms, frames, pull_back
from twin.inverse.layer_response import LayerResponse
from twin.shell import Shell
from twin.shell.topology import stencils

THICKNESS = np.array([0.2, 0.25, 0.15, 0.2])
RATIO = np.array([1.0, 1.5, 0.8, 1.0])
ACTIVATION = 0.9


@pytest.fixture(scope="module")
def bent():
    """A crumpled small film with random layers: mesh, shape, alignment, and its forms."""
    rng = np.random.default_rng(0)
    flat, triangles = mesh_outline(np.array([(-5.0, -4.0), (5.0, -4.0), (5.0, 4.0), (-5.0, 4.0)]), 1.5)
    q = 0.12 * rng.normal(size=(4, len(triangles), 2))
    height = 0.03 * flat[:, 0] ** 2 + 0.05 * flat[:, 1] ** 2
    x = np.column_stack((flat, height)) + 0.02 * rng.normal(size=(len(flat), 3))
    frame = frames(flat, triangles)
    a, b = (pull_back(form, frame) for form in edge_forms(x, triangles, stencils(triangles)))
    return flat, triangles, x, q, a, b


def response(q):
    return LayerResponse(q, THICKNESS, activation=ACTIVATION, modulus_ratio=RATIO)


def test_energy_is_that_of_the_kernels(bent):
    flat, triangles, x, q, a, b = bent
    film = film_from_alignment(flat, triangles, q, layer_thickness_mm=THICKNESS, modulus_ratio=RATIO)
    shell = Shell(film)
    shell.set_activation(ACTIVATION)
    assert film.area_mm2 @ response(q).energy(a, b).value == pytest.approx(shell.energy(x), rel=1e-12)


def test_derivatives_are_those_of_differences(bent):
    _, _, _, q, a, b = bent
    rng = np.random.default_rng(1)
    dq, step = rng.normal(size=q.shape), 1e-6
    plus, minus = response(q + step * dq).energy(a, b), response(q - step * dq).energy(a, b)
    here = response(q)
    by_q = (here.energy(a, b).by_q * dq).sum(axis=(0, 2))
    np.testing.assert_allclose((plus.value - minus.value) / (2 * step), by_q, atol=1e-8)
    by_form = np.einsum("malq,lmq->ma", here.stress_by_q(a, b), dq)
    np.testing.assert_allclose((plus.by_form - minus.by_form) / (2 * step), by_form, atol=1e-7)
    da = rng.normal(size=a.shape)
    change = (here.energy(a + step * da, b).value - here.energy(a - step * da, b).value) / (2 * step)
    np.testing.assert_allclose(change, (here.energy(a, b).by_form[:, :3] * da).sum(axis=1), atol=1e-7)


def test_polydomain_layers_have_finite_derivatives(bent):
    _, _, _, q, a, b = bent
    none = np.zeros_like(q)
    assert np.isfinite(response(none).energy(a, b).by_q).all()
    assert np.isfinite(response(none).stress_by_q(a, b)).all()
