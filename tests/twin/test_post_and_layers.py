"""Settings of the post and of the layers: line width, end length, measured thickness, modulus ratios."""

from dataclasses import replace

import numpy as np
import pytest
from films import PAPER_STACK_MM

from planner.calibration import load_calibration
from planner.errors import InputError
from planner.program import Pass
from planner.strips import strip_program
from twin.film import FilmOptions, build_film, paint_passes
from twin.film.raster import PIXEL_MM
from twin.shell import rest_state

CALIBRATION = load_calibration()
BOUNDS = (np.array([-8.0, -8.0]), np.array([8.0, 8.0]))
PROGRAM = strip_program(CALIBRATION, length_mm=10.0, width_mm=12.0, radius_mm=3.0)
COARSE = FilmOptions(mesh_mm=1.0)


def stroke(*points) -> Pass:
    return Pass(points_mm=points, speed_mm_s=(1.0,) * (len(points) - 1), load_g=(3.0,), side="convex")


def painted(*passes, end_length_mm=0.0) -> np.ndarray:
    """Contraction on the pixels, shape [rows, columns]."""
    raster = paint_passes(passes, CALIBRATION, BOUNDS, line_width_mm=0.8, edge_blur_mm=0.0, end_length_mm=end_length_mm)
    return np.hypot(*raster.q)


def column_of(x_mm: float) -> int:
    return round((x_mm - BOUNDS[0][0]) / PIXEL_MM)


@pytest.mark.parametrize("missing", [0.3, 0.8, 2.05])
def test_alignment_starts_after_the_end_length(missing):
    assert np.array_equal(
        painted(stroke((-4.0, 0.0), (5.0, 0.0)), end_length_mm=missing),
        painted(stroke((-4.0 + missing, 0.0), (5.0, 0.0))),
    )
    # the other way round the other end is missing
    back = painted(stroke((5.0, 0.0), (-4.0, 0.0)), end_length_mm=missing)
    assert back[80, column_of(-4.3)] > 0
    assert not back[80, column_of(5.5 - missing) :].any()


def test_end_length_is_measured_along_the_pass():
    bent = stroke((-4.0, -3.0), (-4.0, 0.0), (4.0, 0.0))
    found = painted(bent, end_length_mm=5.0)
    assert np.array_equal(found > 0, painted(stroke((-2.0, 0.0), (4.0, 0.0))) > 0)


def test_every_pass_loses_its_own_start_and_short_ones_all():
    passes = (stroke((-4.0, 3.0), (4.0, 3.0)), stroke((0.0, 0.0), (0.9, 0.0)), stroke((-4.0, -3.0), (4.0, -3.0)))
    found = painted(*passes, end_length_mm=1.0)
    wanted = painted(stroke((-3.0, 3.0), (4.0, 3.0)), stroke((-3.0, -3.0), (4.0, -3.0)))
    assert np.array_equal(found > 0, wanted > 0)
    assert not painted(passes[1], end_length_mm=1.0).any()


def test_line_width_overrides_the_programs():
    whole = build_film(PROGRAM, COARSE).contraction[0]
    same = build_film(PROGRAM, replace(COARSE, line_width_mm=0.8)).contraction[0]
    thin = build_film(PROGRAM, replace(COARSE, line_width_mm=0.5)).contraction[0]
    np.testing.assert_array_equal(same, whole)
    assert thin.mean() == pytest.approx(0.5 / 0.8 * whole.mean(), rel=0.05)


def test_end_length_reaches_the_film():
    """The strip's passes start 0.8 mm beyond the cut: 3 mm take 2.2 mm from alternate rows at either end."""
    x = np.abs(_centre(build_film(PROGRAM, COARSE))[:, 0])
    plain = build_film(PROGRAM, COARSE).contraction[0]
    short = build_film(PROGRAM, replace(COARSE, end_length_mm=3.0)).contraction[0]
    assert short[x > 4.0].mean() < 0.7 * plain[x > 4.0].mean()
    np.testing.assert_allclose(short[x < 1.5], plain[x < 1.5])


def _centre(film) -> np.ndarray:
    return film.flat_mm[film.triangles].mean(axis=1)


def test_measured_layers_and_moduli_reach_the_rest_state():
    thickness, ratio = (0.18, 0.22, 0.19, 0.25), (1.0, 2.0, 0.5, 1.5)
    made = build_film(PROGRAM, replace(COARSE, layer_thickness_mm=thickness, modulus_ratio=ratio))
    np.testing.assert_array_equal(made.layer_thickness_mm, thickness)
    np.testing.assert_array_equal(made.modulus_ratio, ratio)
    cold = rest_state(made, 0.0)
    # 3/2 of the summed weights, 1/2 of the thickness times the ratio on both points
    assert cold.constant[0] == pytest.approx(1.5 * np.dot(thickness, ratio))
    assert cold.top_mm[0] == pytest.approx(0.5 * sum(thickness))
    stiff_skin = build_film(PROGRAM, replace(COARSE, modulus_ratio=ratio, profile="skin"))
    np.testing.assert_array_equal(stiff_skin.modulus_ratio, [1.0, 1.0, 2.0, 2.0, 0.5, 1.5])
    # the skin is as deep as it was scratched, also in layers that turned out thicker
    np.testing.assert_allclose(stiff_skin.layer_thickness_mm.sum(axis=0), sum(PAPER_STACK_MM))


def test_without_settings_the_programs_layers_count():
    made = build_film(PROGRAM, COARSE)
    np.testing.assert_array_equal(made.layer_thickness_mm, PAPER_STACK_MM)
    np.testing.assert_array_equal(made.modulus_ratio, np.ones(4))


@pytest.mark.parametrize(
    ("settings", "sentences"),
    [
        ({"line_width_mm": 0.0}, ["line width: found 0, allowed are finite values from 0.2; 0.8 mm is the paper's."]),
        ({"edge_blur_mm": -0.1}, ["edge blur: found -0.1, allowed are finite values from 0"]),
        ({"end_length_mm": float("nan")}, ["end length: found nan"]),
        ({"fading_tau_h": -1.0}, ["fading time: found -1"]),
        ({"profile": "deep"}, ["profile: found 'deep', allowed are uniform and skin"]),
        ({"layer_thickness_mm": (0.2, 0.2)}, ["layer thickness: found 2 values, the Program has 4 layers"]),
        ({"modulus_ratio": (1.0, 1.0, 0.0, 1.0)}, ["modulus ratio: found 0, allowed are finite values above 0"]),
        (
            {"modulus_ratio": (1.0,), "layer_thickness_mm": (0.2, 0.2, 0.2, float("inf")), "line_width_mm": -1.0},
            ["line width", "layer thickness: found inf", "modulus ratio: found 1 values"],
        ),
    ],
)
def test_settings_that_make_no_film_are_refused_together(settings, sentences):
    with pytest.raises(InputError) as caught:
        build_film(PROGRAM, replace(COARSE, **settings))
    assert len(caught.value.problems) == len(sentences)
    for problem, sentence in zip(caught.value.problems, sentences, strict=True):
        assert problem.startswith(sentence)
