import numpy as np
import pytest

from planner.calibration import load_calibration
from planner.plan import plan
from planner.target import mesh_outline
from scenes.case import load_case
from twin.film import FilmOptions, build_film
from twin.inverse.at_target import TargetEnergy
from twin.inverse.field_control import FieldControl
from twin.inverse.painted import painted_layer
from twin.inverse.pass_control import PassControl
from twin.inverse.traced import pass_bounds, pass_contraction, with_contraction

SQUARE = np.array([(-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0)])


@pytest.fixture(scope="module")
def program():
    return plan(load_case("sphere_cap").make_target()).program


@pytest.fixture(scope="module")
def film(program):
    return build_film(program, FilmOptions(mesh_mm=1.0))


@pytest.fixture(scope="module")
def painted(program, film):
    outline = np.asarray(program.cut.line_mm)
    bounds = outline.min(axis=0) - 1.0, outline.max(axis=0) + 1.0
    calibration, corners = load_calibration(), film.flat_mm[film.triangles]
    return [painted_layer(layer.passes, calibration, corners, bounds, FilmOptions(), 0.8) for layer in program.layers]


def control_of_passes(program, painted):
    ranges = [pass_bounds(layer.passes, load_calibration()) for layer in program.layers]
    low, high = (np.concatenate(part) for part in zip(*ranges, strict=True))
    lengths = [[len(stroke.speed_mm_s) for stroke in layer.passes] for layer in program.layers]
    return PassControl(painted, lengths, low, high, smoothness=1e-2, damping=1e-3)


def contraction_of(program):
    return np.concatenate([pass_contraction(layer.passes, load_calibration()) for layer in program.layers])


def test_painting_is_linear_in_the_contraction(program, film, painted):
    control = control_of_passes(program, painted)
    double = 2.0 * film.director_rad
    learned = film.contraction[..., None] * np.stack((np.cos(double), np.sin(double)), axis=-1)
    np.testing.assert_allclose(control._paint(contraction_of(program)), learned, atol=1e-12)


def test_speeds_give_back_the_contraction(program):
    calibration, passes = load_calibration(), program.layers[0].passes
    low, high = pass_bounds(passes, calibration)
    wanted = low + 0.3 * (high - low)
    given = pass_contraction(with_contraction(passes, wanted, calibration), calibration)
    np.testing.assert_allclose(given, wanted, rtol=1e-3)


@pytest.mark.parametrize("stack", ["all", "pairs", "passes"])
def test_pull_is_the_transpose_of_push_and_the_derivative_of_q(stack, program, film, painted):
    rng = np.random.default_rng(0)
    if stack == "passes":
        control = control_of_passes(program, painted)
        p = control.start(contraction_of(program)) + 0.1 * rng.normal(size=len(contraction_of(program)))
    else:
        count = len(film.flat_mm)
        control = FieldControl(film.triangles, count, layers=4, stack=stack, largest=0.3, smoothness=1e-2, damping=1e-3)
        p = 0.2 * rng.normal(size=(control.fields, count, 2))
    dp, by_q = rng.normal(size=p.shape), rng.normal(size=control.q(p).shape)
    assert (control.pull(p, by_q) * dp).sum() == pytest.approx((control.push(p, dp) * by_q).sum(), rel=1e-10)
    step = 1e-6
    change = (control.q(p + step * dp) - control.q(p - step * dp)) / (2 * step)
    np.testing.assert_allclose(control.push(p, dp), change, atol=1e-7)
    slope = (control.penalty(p + step * dp)[0] - control.penalty(p - step * dp)[0]) / (2 * step)
    assert (control.penalty(p)[1] * dp).sum() == pytest.approx(slope, rel=1e-6)


def test_pairs_of_layers_share_a_field():
    flat, triangles = mesh_outline(SQUARE, 2.5)
    control = FieldControl(triangles, len(flat), layers=4, stack="pairs", largest=0.3, smoothness=1.0, damping=1.0)
    q = control.q(np.random.default_rng(0).normal(size=(2, len(flat), 2)))
    assert np.array_equal(q[0], q[1])
    assert np.array_equal(q[2], q[3])
    assert not np.array_equal(q[0], q[2])


def test_energy_at_the_target_has_the_gradient_of_differences():
    rng = np.random.default_rng(0)
    flat, triangles = mesh_outline(SQUARE, 2.5)
    shape = np.column_stack((flat, 0.02 * (flat**2).sum(axis=1)))
    control = FieldControl(triangles, len(flat), layers=4, stack="all", largest=0.3, smoothness=1e-2, damping=1.0)
    energy = TargetEnergy(shape, triangles, np.full(4, 0.2), control)
    flat = 1.05 * flat + 0.02 * rng.normal(size=flat.shape)
    u = 0.1 * rng.normal(size=(4, len(flat), 2))
    _, by_flat, by_u = energy(flat, u)
    step = 1e-5
    for d_flat, du in ((by_flat, 0.0 * by_u), (0.0 * by_flat, by_u)):
        change = energy(flat + step * d_flat, u + step * du)[0] - energy(flat - step * d_flat, u - step * du)[0]
        assert (by_flat * d_flat).sum() + (by_u * du).sum() == pytest.approx(change / (2 * step), rel=1e-7)
