"""The validation's own instruments, on shapes and numbers that are known by hand."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.validation.bilayers import Bilayer, measured
from benchmarks.validation.cantilever import Flap
from benchmarks.validation.cones import half_angle_deg, total_angle, waves
from benchmarks.validation.director_curvature import CONTRACTION, GRADIENT_RAD_MM, imposed_per_mm2
from benchmarks.validation.films import ALL, disc, rectangle, scratched
from benchmarks.validation.middle import middle_forms
from benchmarks.validation.page import write_page
from benchmarks.validation.section import Check, Section, relative
from planner.calibration import wide_strip

DISC = scratched(disc(10.0), 0.5, 0.0, layers=ALL)


def test_middle_of_a_rolled_strip():
    """A strip stretched by 0.9 along and 1.04 across, rolled to a cylinder of 3 mm, anywhere in space."""
    flat = scratched(rectangle(12.0, 20.0), 0.5, 0.0).flat_mm
    angle = 0.9 * flat[:, 0] / 3.0
    rolled = np.column_stack((3.0 * np.sin(angle), 1.04 * flat[:, 1], 3.0 * np.cos(angle)))
    rolled = Rotation.from_rotvec([0.3, -1.0, 2.0]).apply(rolled) + 5.0
    forms = middle_forms(flat, rolled, (3.0, 6.0))
    assert forms.radius_mm == pytest.approx(3.0, rel=1e-4)
    np.testing.assert_allclose(forms.stretches, (0.9, 1.04), rtol=1e-4)
    np.testing.assert_allclose(forms.second[1], 0.0, atol=1e-6)


def test_middle_of_a_saddle_in_the_films_own_frame():
    x, y = DISC.flat_mm.T
    bent = np.column_stack((x, y, -0.5 * (0.02 * x**2 - 0.01 * y**2) - 0.005 * x * y))
    np.testing.assert_allclose(
        middle_forms(DISC.flat_mm, bent, (3.0, 3.0)).second, [[0.02, 0.005], [0.005, -0.01]], atol=1e-9
    )


@pytest.mark.parametrize("share", [0.6, 0.9])
def test_cone_of_known_angle(share):
    """A paper cone: a disc around which `share` of the full angle is left."""
    arc, angle = np.hypot(*DISC.flat_mm.T), np.arctan2(*DISC.flat_mm.T[::-1])
    distance = share * arc
    bent = np.column_stack((distance * np.cos(angle), distance * np.sin(angle), -np.sqrt(1.0 - share**2) * arc))
    shape: Any = SimpleNamespace(film=DISC, hot_mm=bent)
    assert half_angle_deg(shape) == pytest.approx(np.rad2deg(np.arcsin(share)), abs=0.1)
    assert total_angle(shape) == pytest.approx(share, rel=5e-3)


@pytest.mark.parametrize("count", [2, 3])
def test_waves_are_counted(count):
    x, y = DISC.flat_mm.T
    bent = np.column_stack((x, y, 0.2 * np.hypot(x, y) * np.cos(count * np.arctan2(y, x) + 0.4)))
    shape: Any = SimpleNamespace(film=DISC, hot_mm=bent)
    assert waves(shape) == count


def test_imposed_curvature_is_that_of_the_general_metric():
    """Brioschi's formula on the metric of the pattern, by finite differences, against the closed form."""
    stretch, step = 1.0 - CONTRACTION, 1e-3

    def metric(x: float) -> np.ndarray:
        theta = 0.7 + GRADIENT_RAD_MM * x
        turn = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
        return turn @ np.diag((stretch**2, 1.0 / stretch)) @ turn.T

    # the metric depends on x alone and its determinant D is constant: K = -(g22'' - g22' D'/D ...)/(2 D) = -g22''/(2 D)
    second = (metric(2.0 + step) - 2.0 * metric(2.0) + metric(2.0 - step))[1, 1] / step**2
    expected = -second / (2.0 * stretch)
    assert imposed_per_mm2(np.array(2.0), 0.7) == pytest.approx(expected, rel=1e-4)


def test_elastica_of_a_light_flap_is_the_formula_and_of_a_heavy_one_less():
    light, heavy = (Flap(length_mm=10.0, modulus_mpa=0.3, weight_share=share) for share in (0.01, 20.0))
    assert light.elastica_mm() == pytest.approx(light.formula_mm, rel=1e-4)
    assert Flap(length_mm=10.0, modulus_mpa=0.3).formula_mm == pytest.approx(0.69, abs=0.005)
    assert 0.5 * heavy.length_mm < heavy.elastica_mm() < heavy.length_mm < heavy.formula_mm


def bilayer(contraction: float, temperature_c: float = 80.0) -> Bilayer:
    return Bilayer(
        sample="A",
        temperature_c=temperature_c,
        contraction=contraction,
        lce_mm=0.4,
        pdms_mm=0.4,
        measured_per_mm=1.0,
    )


def test_bilayer_formulas_agree_where_they_must(monkeypatch):
    gentle = bilayer(1e-4)
    assert gentle.finite_per_mm() == pytest.approx(gentle.wide_per_mm(), rel=2e-3)
    monkeypatch.setattr("benchmarks.validation.bilayers.PDMS_MPA", gentle.lce_mpa)
    assert gentle.timoshenko_per_mm() == pytest.approx(1.5 * 1e-4 / 0.8)
    strong = bilayer(0.2)
    assert 1.0 / strong.finite_per_mm() == pytest.approx(float(wide_strip(0.2, (0.4, 0.4), (0,))[0]), rel=1e-5)


def test_measurements_are_read_with_the_cold_curvature_subtracted():
    cases = measured()
    assert len(cases) == 33
    first = cases[0]
    assert (first.sample, first.temperature_c) == ("A", 40.0)
    assert first.measured_per_mm == pytest.approx(1e-3 * (4.8 + 6.2))
    assert first.lce_mm + first.pdms_mm == pytest.approx(0.764)
    assert {case.sample for case in cases if case.temperature_c == 100.0} == {"A", "B", "D"}


def test_page_names_what_fails():
    good = relative("good", 2.0, 2.01, limit=0.01)
    bad = relative("bad", 2.0, 2.1, limit=0.01, unit="mm")
    told = Check(name="told", expected="", found="3", error="", passed=None)
    page = write_page([Section(title="One", checks=(good, bad, told), blocks=("words",))])
    assert "1 of 2 checks hold. These do not: bad." in page
    assert "| bad | 2 mm within 1.0% | 2.1 mm | +5.00% | **fails** |" in page
    assert "| told |  | 3 |  | reported |" in page
    assert "## One\n\nwords" in page
