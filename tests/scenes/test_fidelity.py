"""Regression of fidelity: every built-in case, planned and predicted through passes, gives what its file expects.

`pytest tests/scenes/test_fidelity.py --regen` writes the numbers found into the case files, for review by git diff.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from planner.calibration import load_calibration
from planner.errors import InputError
from planner.plan import plan
from planner.strips import strip_program
from scenes.case import CASES, Case, list_cases, load_case
from scenes.case_expected import Expected, Form, Toleranced
from scenes.case_target import Strip
from twin.bending import bending_radius_mm, principal_curvatures_per_mm
from twin.film import FilmOptions
from twin.predict import PredictOptions, predict
from twin.score import score_surface

NAMES = [case.name for case in list_cases()]
FORMS = [(case.name, method) for case in list_cases() if case.expected for method in case.expected.form]
DIGITS = 4


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What one prediction of a case gave."""

    numbers: dict[str, float]
    form: Form
    stable: bool


def form_of(curvatures_per_mm: np.ndarray) -> Form:
    """Return what two principal curvatures, ascending, make of a film."""
    low, high = curvatures_per_mm
    return "dome" if low > 0 else "bowl" if high < 0 else "saddle"


def foretell(case: Case, method: str) -> Outcome:
    """Plan and predict a case as `lce` does, at the mesh size that its numbers were found at, in memory."""
    assert case.expected
    if isinstance(case.target, Strip):
        program = strip_program(
            load_calibration(),
            length_mm=case.target.length_mm,
            width_mm=case.target.width_mm,
            radius_mm=case.target.bending_radius_mm,
        )
    else:
        target = case.make_target()
        settings = case.plan.model_copy(update={"method": method}).model_dump()
        program = plan(target, **settings).program
    options = PredictOptions(
        film=FilmOptions(mesh_mm=case.expected.mesh_mm),
        temperature_c=case.predict.temperature_c,
        support=case.predict.support,
        seed=case.predict.seed,
        device="cpu",
    )
    shape = predict(program, options)
    if isinstance(case.target, Strip):
        numbers = {"bending_radius_mm": bending_radius_mm(shape)}
    else:
        score = score_surface(shape.top_mm, shape.film.triangles, target).score
        numbers = {"ssim_eq4": score.ssim_eq4, "rms_mm": score.rms_mm}
    form = form_of(principal_curvatures_per_mm(shape.film, shape.hot_mm))
    return Outcome(numbers=numbers, form=form, stable=shape.stable)


@pytest.fixture(scope="session")
def outcome() -> Callable[[Case, str], Outcome]:
    """Predict a case by a method; each pair once a session."""
    made: dict[tuple[str, str], Outcome] = {}

    def of(case: Case, method: str) -> Outcome:
        key = (case.name, method)
        if key not in made:
            made[key] = foretell(case, method)
        return made[key]

    return of


def deviations(expected: Expected, found: dict[str, float]) -> list[str]:
    """Tell each expected number that was not found, or lies beyond its tolerance."""
    told = []
    for name, number in expected.numbers.items():
        value = found.get(name, np.nan)
        if not abs(value - number.value) <= number.tolerance:
            told.append(f"{name}: found {value:.4f}, expected {number.value:.4f} +- {number.tolerance:g}")
    return told


def rewrite_numbers(path: Path, found: dict[str, float]) -> None:
    """Put the numbers found into a case file, leaving everything else as it is."""
    text = path.read_text(encoding="utf-8")
    for name, value in found.items():
        pattern = rf"(?m)^({name} *= *\{{ *value *= *)[^,]+(,)"
        text, count = re.subn(pattern, rf"\g<1>{value:.{DIGITS}f}\g<2>", text)
        assert count == 1, f"{path}: write `{name} = {{ value = 0.0, tolerance = ... }}` under [expected] first"
    path.write_text(text, encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_case_gives_the_numbers_that_its_file_expects(name, outcome, regen):
    case = load_case(name)
    assert case.expected, f"{name}: add an [expected] table to the case file"
    assert case.expected.numbers, f"{name}: expected takes numbers"
    found = outcome(case, case.plan.method)
    assert found.stable
    if regen:
        rewrite_numbers(CASES / f"{name}.toml", found.numbers)
        pytest.skip("numbers written to the case file")
    assert not deviations(case.expected, found.numbers)


@pytest.mark.parametrize(("name", "method"), FORMS)
def test_case_takes_the_form_that_its_file_expects(name, method, outcome):
    case = load_case(name)
    assert case.expected
    found = outcome(case, method)
    assert found.stable
    assert found.form == case.expected.form[method]


def test_the_papers_domes_are_expected_by_both_methods():
    """Fig. 3 of the paper: of an oblate dome perpendicular scratching makes a dome, maximum curvature a saddle."""
    assert load_case("oblate_dome").expected.form == {"perpendicular": "dome", "maximum": "saddle"}
    assert load_case("prolate_dome").expected.form == {"perpendicular": "dome", "maximum": "dome"}


def test_a_number_beyond_its_tolerance_is_told():
    expected = Expected(
        mesh_mm=1.0, ssim_eq4=Toleranced(value=0.5, tolerance=0.02), rms_mm=Toleranced(value=1.0, tolerance=0.05)
    )
    assert deviations(expected, {"ssim_eq4": 0.519, "rms_mm": 0.951}) == []
    assert deviations(expected, {"ssim_eq4": 0.521, "rms_mm": 1.0}) == [
        "ssim_eq4: found 0.5210, expected 0.5000 +- 0.02"
    ]
    assert len(deviations(expected, {"ssim_eq4": np.nan, "rms_mm": 0.9})) == 2
    assert len(deviations(expected, {"ssim_eq4": 0.5})) == 1


def test_regenerated_numbers_replace_only_the_numbers(tmp_path):
    path = tmp_path / "dome.toml"
    path.write_text((CASES / "oblate_dome.toml").read_text() + "# a comment\n")
    before = path.read_text()
    rewrite_numbers(path, {"ssim_eq4": -0.125, "rms_mm": 7.0})
    case = load_case(path)
    assert case.expected
    assert {name: number.value for name, number in case.expected.numbers.items()} == {"ssim_eq4": -0.125, "rms_mm": 7.0}
    original = load_case("oblate_dome").expected
    rewrite_numbers(path, {name: number.value for name, number in original.numbers.items()})
    assert path.read_text() == before
    with pytest.raises(AssertionError, match="bending_radius_mm"):
        rewrite_numbers(path, {"bending_radius_mm": 1.0})


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("tolerance = 0.02", "tolerance = 0"), "expected.ssim_eq4.tolerance"),
        (("tolerance = 0.02", "tolerance = 0.02, unit = 1"), r"\[expected.ssim_eq4\] unit is not a key"),
        (("rms_mm", "rms"), r"\[expected\] rms is not a key of a case; .* did you mean rms_mm"),
        (('"saddle"', '"sadle"'), "saddle"),
    ],
)
def test_a_wrong_expected_table_is_told_where_and_what(tmp_path, change, told):
    path = tmp_path / "case.toml"
    path.write_text((CASES / "oblate_dome.toml").read_text().replace(*change))
    with pytest.raises(InputError, match=told):
        load_case(path)
