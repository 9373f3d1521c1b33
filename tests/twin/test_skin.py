"""Films whose layers are aligned in a skin."""

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from films import PAPER_STACK_MM, azimuthal, ellipse, film, rectangle

from planner.calibration import load_calibration, skin_depth_mm, skin_radius_mm
from planner.errors import InputError
from planner.program import CalibrationStrip
from planner.strips import strip_program
from twin.bending import bending_radius_mm
from twin.film import Film, FilmOptions, coarsen, with_skin
from twin.predict import PredictOptions, heat_film, predict
from twin.shell import rest_state

CALIBRATION = load_calibration()
RECORD = CALIBRATION.record
STRONGEST = float(CALIBRATION.contraction(6.5, 0.5))


def depth(contraction):
    return skin_depth_mm(contraction, STRONGEST, PAPER_STACK_MM, (0, 1))


def test_aligned_layers_are_cut_in_two_and_the_others_stay():
    uniform = film(ellipse(6.0, 5.0), 1.0, contraction=0.1, direction=azimuthal)
    made = with_skin(uniform, RECORD)
    count = len(uniform.triangles)
    assert made.layer_thickness_mm.shape == made.contraction.shape == made.director_rad.shape == (6, count)
    np.testing.assert_allclose(made.contraction, np.repeat([[0], [STRONGEST], [0], [STRONGEST], [0], [0]], count, 1))
    d = float(depth(0.1))
    wanted = np.repeat([[0.2 - d], [d], [0.2 - d], [d], [0.2], [0.2]], count, 1)
    np.testing.assert_allclose(made.layer_thickness_mm, wanted, atol=1e-9)
    np.testing.assert_array_equal(made.director_rad[1], uniform.director_rad[0])
    assert made.thickness_mm == pytest.approx(0.8)


def test_strongest_setting_is_the_uniform_film():
    uniform = film(rectangle(6.0, 5.0), 1.0, contraction=STRONGEST)
    one, other = rest_state(uniform, 0.9), rest_state(with_skin(uniform, RECORD), 0.9)
    np.testing.assert_allclose(other.moments, one.moments, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(other.top_mm, one.top_mm, rtol=1e-6)


def test_layers_thinner_than_the_skin_are_aligned_through():
    uniform = replace(film(rectangle(6.0, 5.0), 1.0, contraction=0.3), layer_thickness_mm=np.full(4, 0.05))
    made = with_skin(uniform, RECORD)
    np.testing.assert_allclose(made.layer_thickness_mm[[0, 2]], 0.0)
    np.testing.assert_allclose(made.layer_thickness_mm[[1, 3]], 0.05)


def test_depth_follows_the_contraction_over_the_film():
    uniform = film(rectangle(10.0, 4.0), 0.8, contraction=1.0)
    x = uniform.flat_mm[uniform.triangles].mean(axis=1)[:, 0]
    graded = replace(uniform, contraction=uniform.contraction * np.clip(0.04 * x, 0.0, 0.3))
    made = with_skin(graded, RECORD)
    np.testing.assert_allclose(made.layer_thickness_mm[1], depth(np.clip(0.04 * x, 0.0, 0.3)))
    assert not made.layer_thickness_mm[1][x < 0].any()


def test_coarse_skin_keeps_its_strength():
    """Where half of a coarse triangle is aligned its skin is half as deep, and no weaker."""
    uniform = film(ellipse(10.0, 8.0), 0.5, contraction=0.15)
    x = uniform.flat_mm[uniform.triangles].mean(axis=1)[:, 0]
    made = with_skin(replace(uniform, contraction=uniform.contraction * (x > 0)), RECORD)
    coarse = coarsen(made, 1.5)
    aligned = coarse.layer_thickness_mm[1] > 1e-6
    assert 0.4 < aligned.mean() < 0.6
    np.testing.assert_allclose(coarse.contraction[1, aligned], STRONGEST, rtol=1e-9)
    volume = coarse.layer_thickness_mm[1] @ coarse.area_mm2
    assert volume == pytest.approx(made.layer_thickness_mm[1] @ made.area_mm2, rel=0.03)


def test_calibration_without_a_depth_is_refused():
    record = RECORD.model_copy(
        update={
            "strip": CalibrationStrip(layer_thickness_mm=(0.2, 0.6), aligned_layers=(1,)),
            "limits": RECORD.limits.model_copy(update={"radius_mm_min": 3.0}),
        }
    )
    with pytest.raises(InputError, match=r"profile: the calibration 'placeholder' does not tell how deep a skin is"):
        with_skin(film(rectangle(6.0, 5.0), 1.0, contraction=0.1), record)


def heated_strip(radius_mm: float, side: Literal["convex", "concave"]) -> float:
    program = strip_program(CALIBRATION, length_mm=12.0, width_mm=20.0, radius_mm=radius_mm, side=side)
    options = FilmOptions(mesh_mm=0.8, profile="skin")
    return bending_radius_mm(predict(program, PredictOptions(film=options, support="free", device="cpu")))


@pytest.mark.parametrize("radius_mm", [3.0, 8.0])
def test_calibration_strip_bends_as_promised(radius_mm):
    assert heated_strip(radius_mm, "convex") == pytest.approx(radius_mm, rel=0.03)


def test_the_same_setting_curves_more_on_the_concave_side():
    d = float(depth(float(CALIBRATION.contraction(*settings_for(8.0)))))
    wanted = float(skin_radius_mm(d, STRONGEST, PAPER_STACK_MM, (2, 3)))
    assert -8.0 / wanted > 2.2
    assert heated_strip(8.0, "concave") == pytest.approx(wanted, rel=0.03)


def settings_for(radius_mm: float) -> tuple[float, float]:
    found = CALIBRATION.settings_for(radius_mm)
    return float(found.load_g[0]), float(found.speed_mm_s[0])


def thin_strip(profile: str) -> float:
    """Radius of a film of 0.1 mm layers, scratched as bends one of 0.2 mm layers to 8 mm."""
    uniform = film(rectangle(8.0, 14.0), 0.6, contraction=float(CALIBRATION.contraction(*settings_for(8.0))))
    thin: Film = replace(uniform, layer_thickness_mm=np.full(4, 0.1))
    made = with_skin(thin, RECORD) if profile == "skin" else thin
    return bending_radius_mm(heat_film(made, PredictOptions(support="free", device="cpu")))


def test_thin_layers_bend_below_3_mm_only_with_a_skin():
    assert thin_strip("skin") < 3.0
    assert thin_strip("uniform") == pytest.approx(4.0, rel=0.03)
