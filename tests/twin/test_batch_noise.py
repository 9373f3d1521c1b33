"""Noisy films: sizes of the errors, what stays, what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from films import azimuthal, ellipse, film, rectangle

from planner.errors import InputError
from twin.batch import ProcessNoise, noisy_films

NONE = ProcessNoise(strain=0.0, layer_strain=0.0, direction_rad=0.0, registration_mm=0.0)


def straight():
    return film(rectangle(40.0, 30.0), 2.5, contraction=0.1)


def test_no_noise_changes_nothing():
    made = film(ellipse(9.0, 6.0), 1.0, contraction=0.15, direction=azimuthal)
    for same in noisy_films(made, NONE, 2, seed=3):
        np.testing.assert_array_equal(same.contraction, made.contraction)
        np.testing.assert_array_equal(same.director_rad, made.director_rad)


def test_films_repeat_with_the_seed_and_do_not_depend_on_their_number():
    made = straight()
    three, five = noisy_films(made, ProcessNoise(), 3, seed=1), noisy_films(made, ProcessNoise(), 5, seed=1)
    for one, other in zip(three, five, strict=False):
        np.testing.assert_array_equal(one.contraction, other.contraction)
        np.testing.assert_array_equal(one.director_rad, other.director_rad)
    assert np.any(three[0].contraction != three[1].contraction)
    assert np.any(noisy_films(made, ProcessNoise(), 1, seed=2)[0].contraction != three[0].contraction)


def test_strains_scatter_as_asked_and_polydomain_layers_stay():
    made = straight()
    films = noisy_films(made, replace(NONE, strain=0.03, layer_strain=0.04), 400, seed=0)
    scale = np.array([noisy.contraction[:2, 0] / 0.1 for noisy in films])
    np.testing.assert_allclose(scale.mean(axis=0), 1.0, atol=0.01)
    np.testing.assert_allclose(scale.std(axis=0), 0.05, rtol=0.12)
    # the common part is what two layers share
    assert np.cov(scale.T)[0, 1] == pytest.approx(0.03**2, abs=4e-4)
    assert all(np.ptp(noisy.contraction[0]) < 1e-15 for noisy in films)
    assert not any(noisy.contraction[2:].any() for noisy in films)


def test_directors_scatter_as_asked_and_vary_over_their_length():
    made = straight()
    centre = made.flat_mm[made.triangles].mean(axis=1)
    films = noisy_films(made, replace(NONE, direction_rad=0.1, direction_length_mm=8.0), 400, seed=0)
    turn = np.array([noisy.director_rad[:2] for noisy in films])
    np.testing.assert_allclose(turn.std(axis=0).mean(axis=1), 0.1, rtol=0.05)
    middle, right = (int(np.argmin(np.hypot(*(centre - place).T))) for place in ((0.0, 0.0), (8.0, 0.0)))
    distance = np.linalg.norm(centre[middle] - centre[right])
    expected = np.exp(-0.5 * (distance / 8.0) ** 2)
    assert np.corrcoef(turn[:, 0, middle], turn[:, 0, right])[0, 1] == pytest.approx(expected, abs=0.08)
    assert np.corrcoef(turn[:, 0, middle], turn[:, 1, middle])[0, 1] == pytest.approx(0.0, abs=0.15)
    stiff = noisy_films(made, replace(NONE, direction_rad=0.1, direction_length_mm=np.inf), 3, seed=0)
    assert max(np.ptp(noisy.director_rad[0]) for noisy in stiff) < 1e-12


def test_layers_shift_as_a_whole():
    """Where the contraction is linear in x and y, a shift lowers it by slope times shift, everywhere inside."""
    made = straight()
    centre = made.flat_mm[made.triangles].mean(axis=1)
    ramp = 0.1 + 0.002 * centre[:, 0] + 0.001 * centre[:, 1]
    made = replace(made, contraction=np.stack((ramp, ramp, 0 * ramp, 0 * ramp)))
    inside = (np.abs(centre[:, 0]) < 17.0) & (np.abs(centre[:, 1]) < 12.0)
    films = noisy_films(made, replace(NONE, registration_mm=0.5), 200, seed=0)
    drop = np.array([ramp - noisy.contraction[:2] for noisy in films])[..., inside]
    assert np.ptp(drop, axis=-1).max() < 1e-9
    assert drop[..., 0].std() == pytest.approx(0.5 * np.hypot(0.002, 0.001), rel=0.12)
    assert all(np.isfinite(noisy.contraction).all() for noisy in films)


def test_impossible_noise_is_refused_with_every_problem():
    made = straight()
    with pytest.raises(InputError) as caught:
        noisy_films(made, ProcessNoise(strain=-0.1, direction_length_mm=0.0, registration_mm=np.nan), 2, seed=0)
    assert [problem.split(":")[0] for problem in caught.value.problems] == [
        "process noise, strain",
        "process noise, direction_length_mm",
        "process noise, registration_mm",
    ]
    with pytest.raises(InputError, match="found count 0"):
        noisy_films(made, NONE, 0, seed=0)
    varied = replace(made, layer_thickness_mm=np.full((4, len(made.triangles)), 0.2))
    assert len(noisy_films(varied, replace(ProcessNoise(), registration_mm=0.0), 1, seed=0)) == 1
    with pytest.raises(InputError, match="cannot be shifted"):
        noisy_films(varied, ProcessNoise(), 1, seed=0)


def test_shifts_keep_the_contraction_where_directors_vary():
    made = film(ellipse(12.0, 9.0), 1.0, contraction=0.15, direction=azimuthal)
    total = float(made.contraction[0] @ made.area_mm2)
    for noisy in noisy_films(made, replace(NONE, registration_mm=0.3), 5, seed=0):
        assert float(noisy.contraction[0] @ made.area_mm2) == pytest.approx(total, rel=2e-3)


def test_numbers_come_back_as_they_are_written():
    plain = ProcessNoise(direction_rad=np.radians(5.0)).plain()
    assert plain["direction_deg"] == 5.0
    assert set(plain) == {"strain", "layer_strain", "direction_deg", "direction_length_mm", "registration_mm"}
    assert ProcessNoise(direction_length_mm=np.inf).plain()["direction_length_mm"] == "inf"


def test_deviations_are_scaled_and_the_length_is_not():
    noise = ProcessNoise(strain=0.04, direction_length_mm=3.0).scaled(0.5)
    assert (noise.strain, noise.layer_strain, noise.registration_mm) == pytest.approx((0.02, 0.025, 0.1))
    assert noise.direction_rad == pytest.approx(np.radians(2.5))
    assert noise.direction_length_mm == 3.0
