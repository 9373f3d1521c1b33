"""Alignment that fades between scratch and cure."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.calibration import load_calibration
from planner.program import Layer, Pass, Program, layer_times, load_machine
from planner.strips import strip_program
from twin.fading import pass_strengths, remaining_alignment
from twin.film import FilmOptions, build_film, paint_passes

CALIBRATION = load_calibration()
HOUR_S = 3600.0
COARSE = FilmOptions(mesh_mm=1.0)


@pytest.fixture(scope="module")
def program() -> Program:
    return strip_program(CALIBRATION, length_mm=10.0, width_mm=12.0, radius_mm=3.0)


def test_a_third_is_left_after_tau():
    assert remaining_alignment(0.0) == 1.0
    assert remaining_alignment(2.5 * HOUR_S) == pytest.approx(np.exp(-1.0))
    assert remaining_alignment(HOUR_S) == pytest.approx(0.852, abs=5e-4)
    np.testing.assert_allclose(remaining_alignment([0.0, HOUR_S], tau_h=1.0), [1.0, np.exp(-1.0)])


@given(st.floats(0.0, 1e5), st.floats(0.0, 1e5), st.floats(0.1, 10.0))
def test_waiting_longer_never_leaves_more(one, other, tau_h):
    early, late = sorted((one, other))
    assert 0.0 <= remaining_alignment(late, tau_h=tau_h) <= remaining_alignment(early, tau_h=tau_h) <= 1.0


def test_first_pass_of_a_layer_fades_most_and_layers_do_not_wait_for_each_other(program):
    strengths = pass_strengths(program, load_machine(), tau_h=0.1)
    assert [len(one) for one in strengths] == [len(layer.passes) for layer in program.layers]
    assert np.all(np.diff(strengths[0]) > 0.0)
    # the same passes in both layers; only the first waits for the pump before its first pass
    np.testing.assert_allclose(strengths[1], strengths[0], rtol=1e-12)
    waiting = np.array(layer_times(program, load_machine())[0].pass_to_cure_s)
    np.testing.assert_allclose(strengths[0], np.exp(-((waiting / 360.0) ** 2)), rtol=1e-12)


def test_strength_multiplies_what_a_pass_leaves():
    passes = [
        Pass(points_mm=((-3.0, y), (3.0, y)), speed_mm_s=(1.0,), load_g=(3.0,), side="convex") for y in (-1.5, 1.5)
    ]
    bounds = (np.array([-5.0, -4.0]), np.array([5.0, 4.0]))
    whole, faded = (
        paint_passes(passes, CALIBRATION, bounds, line_width_mm=0.8, edge_blur_mm=0.1, strength=strength)
        for strength in (None, (0.25, 1.0))
    )
    lower = np.arange(whole.q.shape[1]) < whole.q.shape[1] // 2
    np.testing.assert_allclose(faded.q[:, lower], 0.25 * whole.q[:, lower], atol=1e-15)
    np.testing.assert_array_equal(faded.q[:, ~lower], whole.q[:, ~lower])


def test_film_of_a_faded_program_contracts_less_where_it_waited(program):
    fresh = build_film(program, COARSE)
    faded = build_film(program, replace(COARSE, fading_tau_h=0.08))
    centre = fresh.flat_mm[fresh.triangles].mean(axis=1)
    share = faded.contraction[0] / fresh.contraction[0]
    left = pass_strengths(program, load_machine(), tau_h=0.08)[0]
    rows = np.array([stroke.points_mm[0][1] for stroke in program.layers[0].passes])
    np.testing.assert_allclose(share, np.interp(centre[:, 1], rows, left), rtol=0.05)
    assert share.min() < 0.8
    np.testing.assert_array_equal(faded.contraction[2:], 0.0)


@pytest.mark.parametrize("off", [None, 0.0])
def test_no_fading_unless_asked_for(program, off):
    fresh, same = build_film(program, COARSE), build_film(program, replace(COARSE, fading_tau_h=off))
    np.testing.assert_array_equal(same.contraction, fresh.contraction)


def test_a_slower_machine_leaves_less(program):
    machine = load_machine()
    stage = machine.stage.model_copy(update={"travel_speed_mm_s": 0.02})
    options = replace(COARSE, fading_tau_h=0.5)
    quick = build_film(program, options)
    slow = build_film(program, replace(options, machine=machine.model_copy(update={"stage": stage})))
    assert slow.contraction[0].mean() < 0.98 * quick.contraction[0].mean()


def test_faded_skin_is_as_deep_but_weaker(program):
    skin = replace(COARSE, profile="skin")
    fresh, faded = build_film(program, skin), build_film(program, replace(skin, fading_tau_h=0.08))
    np.testing.assert_allclose(faded.layer_thickness_mm, fresh.layer_thickness_mm, atol=1e-12)
    assert faded.contraction[1].min() < 0.8 * fresh.contraction[1].min()


def test_polydomain_layers_have_nothing_to_fade(program):
    bare = program.model_copy(update={"layers": tuple(Layer.of(i, 0.2) for i in range(4))})
    assert all(len(one) == 0 for one in pass_strengths(bare, load_machine()))
    assert not build_film(bare, replace(COARSE, fading_tau_h=2.5)).contraction.any()
