"""The expected loss of a design to noise, and designs that lose less."""

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
from twin.inverse.expected_loss import ExpectedLoss
from twin.inverse.harden import NOISE_WEIGHT, Hardening
from twin.inverse.noise import ProcessErrors
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
    refinement = stages._refinement(world, control, field.forms, field.hold, field.weight_per_mm3)
    errors = ProcessErrors(world.newton.shell.film, ProcessNoise(), seed=0)
    hardening = Hardening(refinement, world, control, errors)
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


def test_hardening_lowers_the_loss_and_keeps_the_shape(opened):
    _, _, _, hardening, design = opened

    told = []

    def loss_of(one):
        loss = hardening._loss(one)
        loss.at(one.q, one.shape.vertices_mm)
        return loss.value

    way = hardening.harden(design, 12, told.append)
    assert way[0] is design
    hardened = way[-1]
    assert told[-1] == 1.0
    before, after = loss_of(design), loss_of(hardened)
    assert after < 0.8 * before
    assert hardened.shape.measured.ssim > 0.95
    assert design.shape.measured.ssim - hardened.shape.measured.ssim < NOISE_WEIGHT * (before - after)


def test_films_that_leave_are_held_there_and_the_design_goes_back_if_its_own_does(opened, monkeypatch):
    world, _, refinement, _, design = opened
    film = world.newton.shell.film
    nowhere = np.zeros(len(film.flat_mm))
    corner = 2.0 * (np.linalg.norm(film.flat_mm - film.flat_mm[0], axis=1) < 2.0)
    started, weights, before, weight = [], [], refinement.anchor.hold, refinement.weight_per_mm3

    class Hardens:
        def harden(self, one, evaluations, progress):
            started.append(one)
            weights.append(refinement.weight_per_mm3)
            return [one, SimpleNamespace(**{**vars(one), "p": one.p + len(started)})]

        def noisy(self, one, number):
            return [one.q]

    # none leaves, then a noisy film, the design's own, none, a noisy one again
    ends = iter([nowhere, nowhere, nowhere, corner, corner, nowhere, nowhere, nowhere, corner])
    monkeypatch.setattr(basin, "_left_mm", lambda *_: next(ends))
    refinement.weight_per_mm3 = 9e-3
    found = hardened_in_basin(opened, Hardens(), rounds=5)
    raised, refinement.anchor.hold, refinement.weight_per_mm3 = refinement.anchor.hold / before, before, weight
    far = np.linalg.norm(film.flat_mm[film.triangles].mean(axis=1) - film.flat_mm[0], axis=1) > 12.0
    assert raised.max() == pytest.approx(basin.HELD**3, rel=0.1)
    assert raised[far].max() < 1.01
    assert weights == pytest.approx([9e-3, 3e-3, 3e-3, 9e-3, 3e-3])
    np.testing.assert_allclose([one.p[0, 0, 0] - design.p[0, 0, 0] for one in started], [0.0, 1.0, 3.0, 3.0, 7.0])
    # the last one that no film left
    assert found.p[0, 0, 0] - design.p[0, 0, 0] == pytest.approx(7.0)


@pytest.mark.parametrize(("leaves_from", "most"), [(9, 1), (6, 4), (1, 4)])
def test_the_last_step_that_lands_is_found_by_halving(opened, monkeypatch, leaves_from, most):
    world, _, _, _, _ = opened
    way, asked = [SimpleNamespace(q=number) for number in range(9)], []

    def left_mm(_, one, q):
        asked.append(q)
        return np.full(3, 2.0 * basin.LEFT_MM * q if q >= leaves_from else 0.0)

    monkeypatch.setattr(basin, "_left_mm", left_mm)
    landed, off_mm = basin._landed(world, cast(Any, way))
    assert landed == leaves_from - 1
    assert (
        (off_mm is None)
        if leaves_from == 9
        else (off_mm is not None and off_mm.max() == 2.0 * basin.LEFT_MM * leaves_from)
    )
    assert len(asked) <= most


def test_a_film_that_cannot_be_heated_has_left_everywhere(opened, monkeypatch):
    world, _, refinement, _, design = opened
    before = refinement.anchor.hold

    def fails(q):
        raise SolverError("no equilibrium on the way")

    class Hardens:
        def harden(self, one, evaluations, progress):
            return [one, SimpleNamespace(**vars(one))]

        def noisy(self, one, number):
            return []

    monkeypatch.setattr(world, "ramp", fails)
    found = hardened_in_basin(opened, Hardens(), rounds=1)
    raised, refinement.anchor.hold = refinement.anchor.hold / before, before
    assert found is design
    np.testing.assert_allclose(raised, basin.HELD)


def test_a_round_without_a_step_is_no_film_that_leaves(opened):
    _, _, refinement, _, design = opened

    class Hardens:
        def harden(self, one, evaluations, progress):
            return [one]

        def noisy(self, one, number):
            return []

    weight, refinement.weight_per_mm3 = refinement.weight_per_mm3, 9e-3
    found = hardened_in_basin(opened, Hardens(), rounds=1)
    lowered, refinement.weight_per_mm3 = refinement.weight_per_mm3, weight
    assert found is design
    assert lowered == pytest.approx(3e-3)
