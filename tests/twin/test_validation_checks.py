"""The cheap checks of the validation, each through the twin; the whole page is a slow test."""

import numpy as np
import pytest

from benchmarks.validation import balance, bilayers
from benchmarks.validation.cantilever import Flap, sag_mm
from benchmarks.validation.films import THICKNESS_MM, rectangle, scratched
from benchmarks.validation.small_strain import SMALL, free_patch, metric
from benchmarks.validation.strips import LIMIT, LIMIT_LARGE, TABLE, read_strip, strip_size_mm


@pytest.mark.parametrize("row", [TABLE[6], TABLE[-1]])
def test_strips_bend_and_stretch_as_the_table(row):
    contraction, radius, along, across = row
    limit = LIMIT if contraction <= 0.35 else LIMIT_LARGE
    forms = read_strip(contraction, strip_size_mm(radius), 0.8)
    assert forms.radius_mm == pytest.approx(radius, rel=limit)
    np.testing.assert_allclose(forms.stretches, (along, across), rtol=limit)


@pytest.mark.slow
@pytest.mark.parametrize("row", TABLE)
def test_all_strips_at_the_default_mesh(row):
    contraction, radius, along, across = row
    limit = LIMIT if contraction <= 0.35 else LIMIT_LARGE
    forms = read_strip(contraction, strip_size_mm(radius), 0.6)
    assert forms.radius_mm == pytest.approx(radius, rel=limit)
    np.testing.assert_allclose(forms.stretches, (along, across), rtol=limit)


def test_bilayer_of_two_directors_takes_its_preferred_forms():
    """Rest forms a = (A1 + A2)/2 and b = 3/(4H) (A1 - A2), the convex side counted positive."""
    lower, upper = (1.0, 0.5), (0.7, 1.8)
    first, second = (metric(SMALL * contraction, angle) for contraction, angle in (lower, upper))
    found = free_patch(lower, upper)
    np.testing.assert_allclose(found.bend, -0.75 * (first - second) / SMALL, atol=0.015)
    np.testing.assert_allclose(found.shrink, (0.5 * (first + second) - np.eye(2)) / SMALL, atol=0.01)


def test_light_cantilever_sags_as_the_formula():
    flap = Flap(length_mm=10.0, modulus_mpa=0.3, weight_share=0.02)
    assert sag_mm(flap, 0.6)[0] == pytest.approx(flap.formula_mm, rel=0.02)


def test_heating_puts_in_the_energy_that_is_stored():
    put_in, stored = balance.heating_work(scratched(rectangle(8.0, 12.0), 1.2, 0.2))
    assert stored > 0.1
    assert put_in == pytest.approx(stored, rel=1e-4)


def test_forces_on_the_plate_balance(tmp_path):
    assert all(check.passed for check in balance.run(tmp_path).checks)


def test_film_of_two_moduli_bends_as_the_reduced_energy():
    case = next(case for case in bilayers.measured() if (case.sample, case.temperature_c) == ("C", 90.0))
    assert case.lce_mpa < 1.0 < bilayers.PDMS_MPA
    assert case.lce_mm + case.pdms_mm != pytest.approx(THICKNESS_MM)
    assert bilayers.twin_per_mm(case) == pytest.approx(case.finite_per_mm(), rel=0.02)


def test_bilayer_section_reproduces_its_medians(tmp_path):
    section = bilayers.run(tmp_path)
    assert all(check.passed for check in section.checks)
    assert (tmp_path / "pictures" / "validation-bilayers.png").stat().st_size < 200_000
