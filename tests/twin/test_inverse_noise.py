from dataclasses import replace

import numpy as np
import pytest

from planner.target import mesh_outline
from twin.batch import ProcessNoise, noisy_films
from twin.film import film_from_alignment
from twin.inverse.noise import ProcessErrors

NONE = ProcessNoise(strain=0.0, layer_strain=0.0, direction_rad=0.0, registration_mm=0.0)
KINDS = {
    "strain": {"strain": 0.05},
    "layer_strain": {"layer_strain": 0.05},
    "registration": {"registration_mm": 0.2},
    "direction": {"direction_rad": 0.02},
    "direction over several passes": {"direction_rad": 0.02, "direction_length_mm": 10.0},
    "direction of whole layers": {"direction_rad": 0.02, "direction_length_mm": np.inf},
}


@pytest.fixture(scope="module")
def film():
    flat, triangles = mesh_outline(np.array([(-12.0, -9.0), (12.0, -9.0), (12.0, 9.0), (-12.0, 9.0)]), 1.5)
    x, y = flat[triangles].mean(axis=1).T
    q = np.stack([np.column_stack((0.1 + 0.02 * np.sin(x / 5.0 + k), 0.05 * np.cos(y / 4.0 - k))) for k in range(4)])
    return film_from_alignment(flat, triangles, q, layer_thickness_mm=np.full(4, 0.2))


@pytest.mark.parametrize("kind", KINDS)
def test_the_variance_is_that_of_noisy_films(film, kind):
    """Of a smooth functional, over 400 films: its relative error is about sqrt(2/400)."""
    noise = replace(NONE, **KINDS[kind])
    q, s = film.alignment, np.cos(np.arange(4.0))[:, None, None] * np.ones((4, len(film.triangles), 2))
    s[..., 1] *= film.flat_mm[film.triangles].mean(axis=1)[:, 0] / 12.0
    value, spread, _ = ProcessErrors(film, noise, seed=0).variance(q, s)
    drawn = [float(((noisy.alignment - q) * s).sum()) for noisy in noisy_films(film, noise, 400, 1)]
    assert value == pytest.approx(np.var(drawn), rel=0.25)
    assert value == pytest.approx(float((spread * s).sum()), rel=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_its_gradient_is_that_of_differences(film, kind):
    rng = np.random.default_rng(2)
    errors = ProcessErrors(film, replace(NONE, **KINDS[kind]), seed=0)
    q, s, dq = film.alignment, rng.normal(size=(4, len(film.triangles), 2)), rng.normal(size=film.contraction.shape)
    dq = np.stack((dq, dq[::-1]), axis=-1)
    by_q = errors.variance(q, s)[2]
    step = 1e-4
    slope = (errors.variance(q + step * dq, s)[0] - errors.variance(q - step * dq, s)[0]) / (2.0 * step)
    assert 2.0 * float((by_q * dq).sum()) == pytest.approx(slope, rel=1e-7)


@pytest.mark.parametrize("kind", ["direction", "direction over several passes"])
def test_correlated_directions_are_summed_up_on_a_grid(film, kind):
    """Against the correlation of each triangle with each."""
    noise = replace(NONE, **KINDS[kind])
    q, s = film.alignment, np.random.default_rng(3).normal(size=(4, len(film.triangles), 2)) + 0.5
    centre = film.flat_mm[film.triangles].mean(axis=1)
    distance = np.linalg.norm(centre[:, None] - centre[None], axis=2)
    correlation = np.exp(-0.5 * (distance / noise.direction_length_mm) ** 2)
    turned = 2.0 * noise.direction_rad * (q[..., 0] * s[..., 1] - q[..., 1] * s[..., 0])
    dense = sum(float(own @ correlation @ own) for own in turned)
    assert ProcessErrors(film, noise, seed=0).variance(q, s)[0] == pytest.approx(dense, rel=0.02)


def test_examples_add_up_to_the_covariance(film):
    """Exactly for what is not random, the shifts and strains."""
    noise = ProcessNoise(direction_rad=0.0)
    q, s = film.alignment, np.random.default_rng(4).normal(size=(4, len(film.triangles), 2))
    errors = ProcessErrors(film, noise, seed=0)
    added = sum(float((change * s).sum()) ** 2 for change in errors.examples(q))
    assert errors.variance(q, s)[0] == pytest.approx(added, rel=1e-12)


def test_drawn_films_are_others_for_each_number_and_not_those_of_the_report(film):
    errors = ProcessErrors(film, ProcessNoise(), seed=0)
    drawn = errors.draw(film, 2, 1)
    np.testing.assert_array_equal(drawn, errors.draw(film, 2, 1))
    others = [noisy.alignment for noisy in noisy_films(film, ProcessNoise(), 32, 0)]
    for other in (*errors.draw(film, 2, 0), *others):
        assert min(np.abs(other - one).max() for one in drawn) > 1e-3
    np.testing.assert_allclose(ProcessErrors(film, NONE, seed=0).draw(film, 1, 0)[0], film.alignment, atol=1e-12)
