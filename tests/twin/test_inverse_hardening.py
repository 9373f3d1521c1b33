"""The expected loss of a design to noise, and designs that lose less."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy.stats import norm

from planner.calibration import load_calibration
from planner.errors import SolverError
from scenes.case import load_case
from twin.batch import ProcessNoise
from twin.film import FilmOptions
from twin.inverse import basin
from twin.inverse import world as world_module
from twin.inverse.expected_loss import NOISE_WEIGHT, ExpectedLoss
from twin.inverse.noise import BORNE, BORNE_LENGTH_MM, ProcessErrors
from twin.inverse.noise_costs import TOGETHER, noise_costs
from twin.inverse.on_the_way import FIRST, LAST, PARTED_MM
from twin.inverse.options import InverseOptions
from twin.inverse.search import Search
from twin.inverse.stages import Stages
from twin.predict import PredictOptions
from twin.temperature import TemperatureGapModel

SMALL = InverseOptions(heated=PredictOptions(film=FilmOptions(mesh_mm=1.0)), coarse_triangles=300)


@pytest.fixture(scope="module")
def stages():
    return Stages(load_case("sphere_cap").make_target(), load_calibration(), SMALL, Search(None, None, None))


@pytest.fixture(scope="module")
def field(stages):
    return stages.coarse()


@pytest.fixture(scope="module")
def opened(stages, field):
    """World, control, refinement, hardening and design of the coarse field, with the plate under it."""
    control = stages._control(field.triangles, len(field.flat_mm))
    world = stages._world(field.flat_mm, field.triangles, control.q(field.u))
    refinement = stages._refinement(world, control, field.forms, field.hold, field.weight_per_mm3)
    with stages._hardening(refinement, world, control) as hardening:
        yield world, control, refinement, hardening, refinement.design(field.u, field.vertices_mm)
    world.newton.close()


def hardened_in_basin(opened, hardens, *, rounds):
    """What the basin makes of a stand-in's ways, in as many rounds, from the design."""
    world, _, refinement, _, design = opened
    return basin.harden_in_basin(
        refinement,
        cast(Any, hardens),
        world,
        design,
        rounds=rounds,
        evaluations=9,
        go_on=lambda _: True,
        progress=lambda _: None,
    )


def test_the_gradient_of_the_expected_loss_is_that_of_differences(opened, monkeypatch):
    """Through the equilibrium, in the soft ways of one design."""
    world, control, _, _, design = opened
    assert (design.shape.vertices_mm[:, 2] < 0.01).any()
    assert world.linearise(design.q, design.shape.vertices_mm)
    errors = ProcessErrors(world.newton.shell.film, ProcessNoise(), seed=0)
    loss = ExpectedLoss(world, errors, design.shape.measured.model, design.q)
    loss.at(design.q, design.shape.vertices_mm)
    by_q, by_vertices = loss.gradient()
    gradient = by_q + world.pull(by_vertices)
    du = control.precondition(np.random.default_rng(0).normal(size=design.p.shape))
    dq = control.push(design.p, du / np.abs(du).max())

    def value(step):
        q = design.q + step * dq
        vertices = world.balance(q, design.shape.vertices_mm)
        assert world.linearise(q, vertices)
        loss.at(q, vertices)
        return loss.value

    def difference(step):
        return (value(step) - value(-step)) / (2.0 * step)

    monkeypatch.setattr(world_module, "TOLERANCE", 1e-11)
    assert float((gradient * dq).sum()) == pytest.approx(difference(1e-5), rel=1e-3)


def test_the_softest_place_of_the_ramp_is_on_it_and_its_gradient_is_that_of_differences(opened, monkeypatch):
    _, control, _, hardening, design = opened
    on_the_way = hardening._on_the_way
    world = on_the_way._world
    vertices = on_the_way.begin(design)
    assert FIRST <= world.activation <= LAST
    own = on_the_way.at(design.q, vertices)
    np.testing.assert_allclose(own, vertices, atol=1e-4)
    # lower than hot, but risen: not on a branch of its own
    assert 0.1 < np.ptp(own[:, 2]) / np.ptp(design.shape.vertices_mm[:, 2]) < 1.0
    assert on_the_way.value > 0.0
    gradient = on_the_way.gradient()
    du = control.precondition(np.random.default_rng(1).normal(size=design.p.shape))
    dq = control.push(design.p, du / np.abs(du).max())

    def value(step):
        on_the_way.at(design.q + step * dq, vertices)
        return on_the_way.value

    monkeypatch.setattr(world_module, "TOLERANCE", 1e-11)
    difference = (value(1e-5) - value(-1e-5)) / 2e-5
    assert float((gradient * dq).sum()) == pytest.approx(difference, rel=1e-3)


def test_where_a_film_parts_from_a_design_is_remembered(opened, monkeypatch):
    _, _, _, hardening, design = opened
    on_the_way = hardening._on_the_way
    softest = on_the_way.begin(design)
    monkeypatch.setattr(on_the_way, "_parted", None)
    on_the_way.left_by(1.01 * design.q, design.q)
    np.testing.assert_array_equal(on_the_way.begin(design), softest)
    # as good as a flat film: it parts as soon as the design has risen
    on_the_way.left_by(0.01 * design.q, design.q)
    vertices = on_the_way.begin(design)
    assert on_the_way._world.activation == on_the_way._parted
    assert PARTED_MM < np.ptp(vertices[:, 2]) < 0.9 * np.ptp(softest[:, 2])


def test_hardening_lowers_the_loss_and_keeps_the_shape(opened):
    _, _, _, hardening, design = opened

    told = []

    def loss_of(one):
        loss = hardening._loss(one)
        loss.at(one.q, one.shape.vertices_mm)
        return loss.value

    way = hardening.harden(design, 24, told.append)
    assert way[0].p is design.p
    hardened = hardening.measured(way[-1], design)
    assert told[-1] == 1.0
    before, after = loss_of(design), loss_of(hardened)
    assert after < 0.7 * before
    assert hardened.shape.measured.ssim > 0.95
    assert design.shape.measured.ssim - hardened.shape.measured.ssim < NOISE_WEIGHT * (before - after)


class StandIn:
    """Ways of so many steps, each adding its number to the first one's p; what a design costs is `price` of its p."""

    def __init__(self, steps, price=lambda p: 0.0):
        self.steps, self.started, self.left = steps, [], []
        self.price = lambda one: price(one.p.flat[0])

    def harden(self, one, evaluations, progress):
        self.started.append(one)
        at = one.shape.vertices_mm
        return [SimpleNamespace(p=one.p + step, q=one.q + step, vertices_mm=at) for step in range(self.steps + 1)]

    def measured(self, point, near):
        return SimpleNamespace(**{**vars(near), "p": point.p, "q": point.q})

    def left_by(self, q, meant_q):
        self.left.append(meant_q)

    def noisy(self, one, number):
        return [one.q]


def test_noisy_films_that_leave_are_held_there_and_the_anchor_is_let_go_after_a_round_without(opened, monkeypatch):
    world, _, refinement, _, design = opened
    film = world.newton.shell.film
    nowhere = np.zeros(len(film.flat_mm))
    corner = 3.0 * (np.linalg.norm(film.flat_mm - film.flat_mm[0], axis=1) < 2.0)
    before, weight = refinement.anchor.hold, refinement.weight_per_mm3
    # each round asks for the design's own film, then for a noisy one: none leaves, a noisy one, again a noisy one
    ends = iter([nowhere, nowhere, nowhere, corner, nowhere, corner])
    monkeypatch.setattr(basin, "_left_mm", lambda *_: next(ends))
    refinement.weight_per_mm3 = 9e-3
    hardens = StandIn(1)
    found = hardened_in_basin(opened, hardens, rounds=3)
    raised, refinement.anchor.hold = refinement.anchor.hold / before, before
    lowered, refinement.weight_per_mm3 = refinement.weight_per_mm3, weight
    far = np.linalg.norm(film.flat_mm[film.triangles].mean(axis=1) - film.flat_mm[0], axis=1) > 12.0
    assert raised.max() == pytest.approx(basin.HELD**2, rel=0.1)
    assert raised[far].max() < 1.01
    assert lowered == pytest.approx(3e-3)
    assert len(hardens.left) == 2
    moved = [one.p[0, 0, 0] - design.p[0, 0, 0] for one in (*hardens.started, found)]
    # of equal prices the one that no film left
    np.testing.assert_allclose(moved, [0.0, 1.0, 2.0, 1.0])


def test_where_the_own_film_leaves_the_cheapest_step_before_counts(opened, monkeypatch):
    world, _, refinement, _, design = opened
    before, weight = refinement.anchor.hold, refinement.weight_per_mm3
    nowhere, gone = np.zeros(len(world.newton.shell.film.flat_mm)), np.full(len(world.newton.shell.film.flat_mm), 9.0)
    start = design.p.flat[0]
    monkeypatch.setattr(basin, "_left_mm", lambda *found: gone if (found[-1] - design.q).max() > 8.5 else nowhere)
    found = hardened_in_basin(opened, StandIn(10, lambda p: abs(p - start - 4.0)), rounds=1)
    assert found.p.flat[0] - start == pytest.approx(4.0)
    # neither held nor let go
    np.testing.assert_array_equal(refinement.anchor.hold, before)
    assert refinement.weight_per_mm3 == weight


def test_where_no_step_lands_the_whole_anchor_gets_more(opened, monkeypatch):
    world, _, refinement, _, design = opened
    weight, gone = refinement.weight_per_mm3, np.full(len(world.newton.shell.film.flat_mm), 9.0)
    monkeypatch.setattr(basin, "_left_mm", lambda *_: gone)
    found = hardened_in_basin(opened, StandIn(2), rounds=1)
    raised, refinement.weight_per_mm3 = refinement.weight_per_mm3, weight
    assert found is design
    assert raised == pytest.approx(basin.FACTOR * weight)


@pytest.mark.parametrize(("leaves_from", "most"), [(9, 1), (6, 4), (1, 4)])
def test_the_last_step_that_lands_is_found_by_halving(opened, monkeypatch, leaves_from, most):
    world, _, _, _, _ = opened
    way, asked = [SimpleNamespace(q=number, vertices_mm=None) for number in range(9)], []

    def left_mm(_, meant_q, meant_mm, q):
        asked.append(q)
        return np.full(3, 2.0 * basin.LEFT_MM * q if q >= leaves_from else 0.0)

    monkeypatch.setattr(basin, "_left_mm", left_mm)
    assert basin._landed(world, cast(Any, way)) == leaves_from - 1
    assert len(asked) <= most


def test_a_film_that_cannot_be_heated_has_left_everywhere(opened, monkeypatch):
    world, _, _, _, design = opened

    def fails(q):
        raise SolverError("no equilibrium on the way")

    monkeypatch.setattr(world, "ramp", fails)
    assert np.isinf(basin._left_mm(world, design.q, design.shape.vertices_mm, design.q)).all()


def test_a_design_that_cannot_be_heated_or_ends_elsewhere_has_no_price(opened, monkeypatch):
    _, _, _, hardening, design = opened

    def fails(q):
        raise SolverError("no equilibrium on the way")

    price = hardening.price(design)
    assert 0.0 < price < 1.0
    world = hardening._on_the_way._world
    states = world.states(design.q)
    snapped = states[-1][0], -states[-1][1]
    with monkeypatch.context() as patched:
        patched.setattr(world, "states", lambda q: [*states[:-1], snapped])
        assert np.isinf(hardening.price(replace(design)))
    monkeypatch.setattr(world, "states", fails)
    assert np.isinf(hardening.price(replace(design)))


def test_a_design_is_heated_once_however_often_it_is_asked_for(opened, monkeypatch):
    _, _, _, hardening, design = opened
    one, world = replace(design), hardening._on_the_way._world
    price, place = hardening.price(one), world.activation
    monkeypatch.setattr(world, "states", lambda q: pytest.fail("heated twice"))
    world.activation = 0.1
    assert hardening.price(one) == pytest.approx(price, rel=1e-9)
    assert world.activation == place


def test_a_round_without_a_step_is_no_film_that_leaves(opened, monkeypatch):
    world, _, refinement, _, design = opened
    nowhere = np.zeros(len(world.newton.shell.film.flat_mm))
    monkeypatch.setattr(basin, "_left_mm", lambda *_: nowhere)
    weight, refinement.weight_per_mm3 = refinement.weight_per_mm3, 9e-3
    found = hardened_in_basin(opened, StandIn(0), rounds=1)
    lowered, refinement.weight_per_mm3 = refinement.weight_per_mm3, weight
    assert found is design
    assert lowered == pytest.approx(3e-3)


def test_a_search_is_for_half_of_the_deviations_and_for_directions_over_longer_ways(opened):
    world, _, _, hardening, design = opened
    film, s = world.film(design.q), np.random.default_rng(0).normal(size=design.q.shape)
    half = replace(ProcessNoise().scaled(BORNE), direction_length_mm=BORNE_LENGTH_MM)
    assert ProcessNoise().direction_length_mm < BORNE_LENGTH_MM
    searched = hardening._errors.variance(design.q, s)[0]
    assert searched == pytest.approx(ProcessErrors(film, half, seed=0).variance(design.q, s)[0], rel=1e-9)


def test_costs_of_errors_are_what_such_films_lose(opened):
    """Against equilibria of films that err in the strain of the whole film; none of what is switched off."""
    world, _, _, _, design = opened
    film, target, vertices = world.film(design.q), load_case("sphere_cap").make_target(), design.shape.vertices_mm

    def costs(noise):
        found = noise_costs(film, vertices, target, noise, SMALL.heated)
        assert found is not None
        return found

    whole = costs(ProcessNoise())
    assert set(whole) == {"strain", "layer_strain", "registration", "direction", TOGETHER}
    assert max(cost for kind, cost in whole.items() if kind != TOGETHER) < whole[TOGETHER]
    one = costs(ProcessNoise(layer_strain=0.0, registration_mm=0.0, direction_rad=0.0))
    assert one["strain"] == whole["strain"]
    assert one[TOGETHER] == pytest.approx(one["strain"], rel=0.2)  # other draws of the same
    assert one["layer_strain"] == one["registration"] == one["direction"] == 0.0
    errors = 0.05 * norm.ppf((np.arange(16) + 0.5) / 16)
    lost = [design.shape.measured.ssim - world.settle((1.0 + s) * design.q, vertices).measured.ssim for s in errors]
    assert whole["strain"] == pytest.approx(np.mean(lost), rel=0.3)


def test_costs_of_errors_need_one_temperature(opened):
    world, _, _, _, design = opened
    heated = replace(SMALL.heated, temperature_field=TemperatureGapModel())
    target = load_case("sphere_cap").make_target()
    assert noise_costs(world.film(design.q), design.shape.vertices_mm, target, ProcessNoise(), heated) is None
