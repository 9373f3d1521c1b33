"""Strips through the whole chain: calibration -> passes -> film -> ramp -> bending radius."""

from importlib.metadata import version

import numpy as np
import pytest

from planner.calibration import Calibration, load_calibration, wide_strip
from planner.errors import InputError
from planner.program import CalibrationLimits
from planner.strips import strip_program
from twin.bending import bending_radius_mm
from twin.film import FilmOptions
from twin.predict import PredictOptions, predict

STACK = (0.2, 0.2, 0.2, 0.2)
TABLE = {0.05: 14.06, 0.10: 6.96, 0.20: 3.44, 0.30: 2.30, 0.40: 1.75}
"""Contraction -> bending radius of a wide strip [mm] at finite strain; 5 % is calculated, the rest is design data."""


def wide_range_calibration() -> Calibration:
    """The placeholder's form with a range that reaches past e = 40 %."""
    record = load_calibration().record
    limits = CalibrationLimits(
        **{**record.limits.model_dump(), "radius_mm_min": 1.5, "radius_mm_max": 16.0, "load_g_min": 0.1}
    )
    return Calibration(record.model_copy(update={"limits": limits}))


def heated_strip(radius_mm: float, *, width_mm: float = 30.0, side="convex", mesh_mm: float = 0.6):
    program = strip_program(wide_range_calibration(), length_mm=12.0, width_mm=width_mm, radius_mm=radius_mm, side=side)
    return predict(program, PredictOptions(film=FilmOptions(mesh_mm=mesh_mm), support="free", device="cpu"))


@pytest.mark.parametrize("contraction", TABLE)
def test_wide_strip_bends_as_the_table_and_the_calibration_promise(contraction):
    promised = float(wide_strip(contraction, STACK, (0, 1))[0])
    radius = bending_radius_mm(heated_strip(promised))
    assert radius == pytest.approx(promised, rel=0.03)
    assert radius == pytest.approx(TABLE[contraction], rel=0.03)


def test_top_layers_bend_the_other_way():
    radius = bending_radius_mm(heated_strip(5.0, side="concave"))
    assert radius == pytest.approx(-5.0, rel=0.03)


def test_narrow_strip_bends_more_towards_the_narrow_formula():
    """At small strain 1.5 e/H for a narrow strip against 1.125 e/H for a wide one; 1.5 mm is not quite narrow."""
    contraction = 0.05
    promised = float(wide_strip(contraction, STACK, (0, 1))[0])
    narrow = 0.8 / (1.5 * contraction)
    radius = bending_radius_mm(heated_strip(promised, width_mm=1.5, mesh_mm=0.25))
    assert narrow < radius < promised
    assert radius == pytest.approx(narrow, rel=0.10)


def test_passes_give_the_strip_the_contraction_that_was_asked_for():
    program = strip_program(load_calibration(), length_mm=10.0, width_mm=12.0, radius_mm=3.0)
    shape = predict(program, PredictOptions(film=FilmOptions(mesh_mm=2.0), support="free", device="cpu"))
    wanted = load_calibration().contraction(
        *(program.layers[0].passes[0].load_g, program.layers[0].passes[0].speed_mm_s)
    )
    np.testing.assert_allclose(shape.film.contraction[:2], wanted[0], rtol=1e-6)
    np.testing.assert_allclose(shape.film.contraction[2:], 0.0)
    assert program.created_by.version == version("lce-twin")


def test_strip_beyond_the_calibration_is_refused():
    with pytest.raises(InputError, match=r"radius is 1 mm.*1\.8 to 14\.4 mm"):
        strip_program(load_calibration(), length_mm=12.0, width_mm=30.0, radius_mm=1.0)
