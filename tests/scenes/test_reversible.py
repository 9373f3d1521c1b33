"""Every built-in case comes back flat when it is cooled, and says so when it snaps on the way."""

import pytest

from planner.calibration import load_calibration
from planner.plan import plan
from planner.strips import strip_program
from scenes.case import list_cases
from scenes.case_target import Strip
from twin.cycle import back_to_flat_mm, cooled
from twin.film import FilmOptions, build_film
from twin.predict import PredictOptions, heat_film


@pytest.mark.slow
@pytest.mark.parametrize("case", list_cases(), ids=lambda case: case.name)
def test_cooled_case_is_flat_within_a_micrometre(case):
    if isinstance(case.target, Strip):
        program = strip_program(
            load_calibration(),
            length_mm=case.target.length_mm,
            width_mm=case.target.width_mm,
            radius_mm=case.target.bending_radius_mm,
        )
    else:
        program = plan(case.make_target(), method=case.plan.method, seed=case.plan.seed).program
    film = build_film(program, FilmOptions(mesh_mm=1.2))
    shape = heat_film(film, cooled(PredictOptions(support=case.predict.support, device="cpu")))
    assert back_to_flat_mm(shape) < 1e-3
    assert shape.snaps == ()
