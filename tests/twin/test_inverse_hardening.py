"""The expected loss of a design to noise, and designs that lose less."""

import itertools
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from planner.calibration import load_calibration
from planner.errors import SolverError
from scenes.case import load_case
from twin.batch import ProcessNoise
from twin.film import FilmOptions
from twin.inverse import basin
from twin.inverse import world as world_module
from twin.inverse.expected_loss import NOISE_WEIGHT, ExpectedLoss
from twin.inverse.noise import ProcessErrors
from twin.inverse.on_the_way import PLACES, WEIGHT_PER_MM2
from twin.inverse.options import InverseOptions
from twin.inverse.search import Search
from twin.inverse.stages import Stages
from twin.predict import PredictOptions

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
    refinement = stages._refinement(world, control, field.forms, field.weight_per_mm3, 1.0)
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


def test_the_way_up_is_on_the_ramp_and_its_gradient_is_that_of_differences(opened, monkeypatch):
    _, control, _, hardening, design = opened
    on_the_way = hardening._on_the_way
    films = on_the_way.begin(design)
    states = on_the_way._worlds[0].states(design.q)
    np.testing.assert_allclose(on_the_way.end_mm, states[-1][1])
    hot = states[-1][0]
    for share, world, film in zip(PLACES, on_the_way._worlds, films, strict=True):
        assert world.activation == pytest.approx(share * hot)
        # lower than hot, but risen between its neighbours on the ramp: not on a branch of its own
        depth = {at: np.ptp(vertices[:, 2]) for at, vertices in states}
        before = max(at for at in depth if at <= world.activation)
        after = min(at for at in depth if at >= world.activation)
        assert depth[before] - 0.05 < np.ptp(film[:, 2]) < depth[after] + 0.05
    own = on_the_way.at(design.q, films)
    np.testing.assert_allclose(own, films, atol=1e-4)
    assert on_the_way.value > 0.0
    gradient = on_the_way.gradient()
    du = control.precondition(np.random.default_rng(1).normal(size=design.p.shape))
    dq = control.push(design.p, du / np.abs(du).max())

    def value(step):
        on_the_way.at(design.q + step * dq, films)
        return on_the_way.value

    monkeypatch.setattr(world_module, "TOLERANCE", 1e-11)
    difference = (value(1e-5) - value(-1e-5)) / 2e-5
    assert float((gradient * dq).sum()) == pytest.approx(difference, rel=1e-3)


def test_the_way_up_costs_what_heights_and_their_variance_do(opened):
    """By the covariance of the process's examples, all ways of them."""
    _, _, _, hardening, design = opened
    on_the_way = hardening._on_the_way
    films = on_the_way.begin(design)
    on_the_way.at(design.q, films)
    expected = 0.0
    for share, world, film in zip(PLACES, on_the_way._worlds, films, strict=True):
        area = world.vertex_share[:, 0]
        plane = np.column_stack((np.ones(len(film)), world.newton.shell.film.flat_mm))

        def mean_square(height_mm, area=area, plane=plane):
            root = np.sqrt(area)
            fitted = plane @ np.linalg.lstsq(root[:, None] * plane, root * height_mm, rcond=None)[0]
            return float((area * (height_mm - fitted) ** 2).sum())

        expected += mean_square(film[:, 2] - share * design.shape.vertices_mm[:, 2])
        changes = hardening._errors.examples(design.q)
        expected += NOISE_WEIGHT * sum(mean_square(world.push(change)[:, 2]) for change in changes)
    # a few ways, and the examples' finite number of random directions
    assert on_the_way.value == pytest.approx(0.5 * WEIGHT_PER_MM2 * expected, rel=0.15)


def test_hardening_lowers_the_loss_and_keeps_the_shape(opened):
    _, _, _, hardening, design = opened

    told = []

    def loss_of(one):
        loss = hardening._loss(one)
        loss.at(one.q, one.shape.vertices_mm)
        return loss.value

    way = hardening.harden(design, 12, told.append)
    np.testing.assert_array_equal(way[0].p, design.p)
    assert all(after.value < before.value for before, after in itertools.pairwise(way))
    hardened = hardening.measured(way[-1], design)
    assert told[-1] == 1.0
    before, after = loss_of(design), loss_of(hardened)
    assert after < 0.8 * before
    assert hardened.shape.measured.ssim > 0.95
    assert design.shape.measured.ssim - hardened.shape.measured.ssim < NOISE_WEIGHT * (before - after)


class StandIn:
    """Ways of so many steps, each adding its number to the first one's p; what a design costs is `price` of its p.

    Each step lowers the value by a share, `gain`.
    """

    def __init__(self, steps, price=lambda p: 0.0, gain=0.1):
        self.steps, self.gain, self.started, self.tested = steps, gain, [], []
        self.price = lambda one: price(one.p.flat[0])

    def harden(self, one, evaluations, progress):
        self.started.append(one)
        way = [one]
        for step in range(1, self.steps + 1):
            value = (1.0 - self.gain) * way[-1].value
            way.append(SimpleNamespace(**{**vars(one), "p": one.p + step, "value": value}))
        return way

    def measured(self, point, near):
        return point

    def noisy(self, one):
        self.tested.append(len(self.started) - 1)
        return [one.q]


def test_a_design_that_noisy_films_prefer_is_kept_and_from_another_the_search_goes_back(opened, monkeypatch):
    _, _, refinement, _, design = opened
    weight = refinement.weight_per_mm3
    losses = iter([0.10, 0.12, 0.08])
    monkeypatch.setattr(basin, "_dissimilarity", lambda *_: next(losses))
    monkeypatch.setattr(basin, "TESTED_EVERY", 1)
    refinement.weight_per_mm3 = 90.0 * basin.WEAKEST_PER_MM3
    hardens = StandIn(1)
    found = hardened_in_basin(opened, hardens, rounds=3)
    raised, refinement.way_weight = refinement.way_weight, 1.0
    lowered, refinement.weight_per_mm3 = refinement.weight_per_mm3, weight
    moved = [one.p.flat[0] - design.p.flat[0] for one in (*hardens.started, found)]
    # the third round starts from the first one's design
    np.testing.assert_allclose(moved, [0.0, 1.0, 1.0, 2.0])
    assert raised == basin.INSISTENCE
    # down, up again, down
    assert lowered == pytest.approx(30.0 * basin.WEAKEST_PER_MM3)


def test_where_the_own_film_leaves_the_cheapest_step_before_counts(opened, monkeypatch):
    _, _, refinement, _, design = opened
    weight, start = refinement.weight_per_mm3, design.p.flat[0]
    monkeypatch.setattr(basin, "TESTED_EVERY", 9)
    monkeypatch.setattr(basin, "_left", lambda _, one: one.p.flat[0] - start > 8.5)
    monkeypatch.setattr(basin, "_dissimilarity", lambda *_: 0.1)
    hardens = StandIn(10, lambda p: abs(p - start - 4.0) if p - start < 8.5 else np.inf)
    hardened_in_basin(opened, hardens, rounds=2)
    refinement.weight_per_mm3 = weight
    assert hardens.started[1].p.flat[0] - start == pytest.approx(4.0)
    assert refinement.way_weight == 1.0


def test_where_no_step_lands_the_whole_anchor_gets_more(opened, monkeypatch):
    _, _, refinement, _, design = opened
    weight = refinement.weight_per_mm3
    monkeypatch.setattr(basin, "_left", lambda *_: True)
    monkeypatch.setattr(basin, "_dissimilarity", lambda *_: 0.1)
    found = hardened_in_basin(opened, StandIn(2, lambda p: np.inf), rounds=1)
    raised, refinement.weight_per_mm3 = refinement.weight_per_mm3, weight
    assert found is design
    assert raised == pytest.approx(basin.FACTOR * weight)


@pytest.mark.parametrize(("leaves_from", "most"), [(9, 1), (6, 4), (1, 4)])
def test_the_last_step_that_lands_is_found_by_halving(opened, monkeypatch, leaves_from, most):
    world, _, _, _, _ = opened
    way, asked = [SimpleNamespace(q=number) for number in range(9)], []

    def left(_, one):
        asked.append(one.q)
        return one.q >= leaves_from

    monkeypatch.setattr(basin, "_left", left)
    assert basin._landed(world, cast(Any, way)) == leaves_from - 1
    assert len(asked) <= most


def test_a_film_that_cannot_be_heated_has_left_and_is_like_nothing(opened, monkeypatch):
    world, _, _, _, design = opened

    def fails(q):
        raise SolverError("no equilibrium on the way")

    point = SimpleNamespace(q=design.q, vertices_mm=design.shape.vertices_mm)
    assert not basin._left(world, cast(Any, point))
    assert basin._dissimilarity(world, design, design.q) == pytest.approx(1.0 - design.shape.measured.ssim, abs=1e-3)
    monkeypatch.setattr(world, "ramp", fails)
    assert basin._left(world, cast(Any, point))
    assert basin._dissimilarity(world, design, design.q) == 1.0


def test_a_design_that_cannot_be_heated_or_ends_elsewhere_has_no_price(opened, monkeypatch):
    _, _, _, hardening, design = opened

    def fails(q):
        raise SolverError("no equilibrium on the way")

    price = hardening.price(design)
    assert 0.0 < price < 1.0
    world = hardening._on_the_way._worlds[0]
    states = world.states(design.q)
    snapped = states[-1][0], -states[-1][1]
    with monkeypatch.context() as patched:
        patched.setattr(world, "states", fails)
        # one that is known already is not heated again
        assert hardening.price(design) == price
        patched.setattr(world, "states", lambda q: [*states[:-1], snapped])
        assert np.isinf(hardening.price(replace(design)))
    monkeypatch.setattr(world, "states", fails)
    assert np.isinf(hardening.price(replace(design)))


def test_noisy_films_are_heated_in_every_second_round_and_the_last(opened, monkeypatch):
    _, _, refinement, _, _ = opened
    monkeypatch.setattr(basin, "_dissimilarity", lambda *_: 0.1)
    weight, hardens = refinement.weight_per_mm3, StandIn(1)
    hardened_in_basin(opened, hardens, rounds=5)
    refinement.weight_per_mm3 = weight
    assert hardens.tested == [1, 3, 4]


def test_settled_designs_are_tested_and_under_the_least_weight_the_search_ends(opened, monkeypatch):
    _, _, refinement, _, design = opened
    monkeypatch.setattr(basin, "_dissimilarity", lambda *_: 0.1)
    weight, refinement.weight_per_mm3 = refinement.weight_per_mm3, 2.0 * basin.WEAKEST_PER_MM3
    hardens = StandIn(1, gain=0.5 * basin.ROUND_SETTLED)
    found = hardened_in_basin(opened, hardens, rounds=6)
    refinement.weight_per_mm3 = weight
    assert hardens.tested == [0, 1]
    assert found.p.flat[0] - design.p.flat[0] == pytest.approx(2.0)


def test_a_round_without_a_step_is_settled(opened, monkeypatch):
    _, _, refinement, _, design = opened
    monkeypatch.setattr(basin, "_dissimilarity", lambda *_: 0.1)
    weight, refinement.weight_per_mm3 = refinement.weight_per_mm3, 9e-3
    found = hardened_in_basin(opened, StandIn(0), rounds=1)
    lowered, refinement.weight_per_mm3 = refinement.weight_per_mm3, weight
    assert found is design
    assert lowered == pytest.approx(3e-3)
