"""Equilibria: agreement with an independent program, flat films, stability, solvers."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from films import azimuthal, ellipse, film, rectangle, reference_shell

from planner.errors import SolverError
from twin.cycle import rigid_distance_mm
from twin.equilibrium import Newton, NewtonOptions, RampOptions, heat, rigid_pins, sparse_solver
from twin.equilibrium.linear import HAVE_PARDISO, PardisoSolver, SuperLuSolver
from twin.film import carry, coarsen
from twin.predict import PLATE_PER_MM, PLATE_REACH_MM, PredictOptions, heat_film
from twin.shell import Shell


@pytest.mark.shared
@pytest.mark.parametrize("name", ["strip_wide", "four_layers_free", "film_on_plate"])
def test_ramp_from_flat_ends_in_the_reference_equilibrium(shared_dir, name):
    data = np.load(shared_dir / "reference" / f"{name}.npz")
    shell = reference_shell(data, name)
    newton = Newton(shell, rigid_pins(shell.film.flat_mm, on_plate="plate" in name))
    last = heat(newton, 1.0, rng=np.random.default_rng(0))[-1].equilibrium
    assert last.stable
    assert last.energy == pytest.approx(float(data["energy_equilibrium"]), rel=1e-9)
    assert rigid_distance_mm(last.vertices_mm, data["equilibrium_mm"]) < 1e-5


@pytest.mark.shared
def test_reference_disc_is_a_saddle_and_the_ramp_leaves_it_for_less_energy(shared_dir):
    """The reference disc is axisymmetric; its Hessian has one negative mode, and an oval shape lies below it."""
    data = np.load(shared_dir / "reference" / "disc_azimuthal.npz")
    shell = reference_shell(data, "disc_azimuthal")
    pins = rigid_pins(shell.film.flat_mm, on_plate=False)
    stay = Newton(shell, pins, NewtonOptions(leave_saddles=False))
    scale = shell.driving_force(np.column_stack((shell.film.flat_mm, np.zeros(shell.vertex_count))))
    saddle = stay.solve(data["equilibrium_mm"], force_scale=scale, tolerance=1e-11)
    assert not saddle.stable
    assert saddle.energy == pytest.approx(float(data["energy_equilibrium"]), rel=1e-9)
    assert rigid_distance_mm(saddle.vertices_mm, data["equilibrium_mm"]) < 1e-5

    last = heat(Newton(shell, pins), 1.0, rng=np.random.default_rng(0))[-1].equilibrium
    assert last.stable
    assert last.energy < saddle.energy - 1e-3


def test_polydomain_film_stays_flat():
    shape = heat_film(film(rectangle(20.0, 15.0), 1.0), PredictOptions(support="free", device="cpu"))
    assert np.ptp(shape.hot_mm[:, 2]) < 1e-9
    flat = shape.film.flat_mm
    assert rigid_distance_mm(shape.hot_mm, np.column_stack((flat, np.zeros(len(flat))))) < 1e-9


def test_polydomain_film_rests_on_the_plate():
    shape = heat_film(film(rectangle(20.0, 15.0), 1.0), PredictOptions(device="cpu"))
    assert shape.stable
    # its weight w = rho g H / mu is carried at the depth d of the plate's layer where stiffness d^2 / (2 reach) = w
    weight = 1.1772e-5 * 0.8 / (0.5 / 3)
    rest = PLATE_REACH_MM - np.sqrt(2.0 * PLATE_REACH_MM * weight / PLATE_PER_MM)
    assert shape.hot_mm[:, 2] == pytest.approx(rest, rel=1e-6)


def test_plate_carries_the_weight_and_nothing_sinks_in():
    made = film(ellipse(12.0, 12.0), 1.0, contraction=0.1, direction=azimuthal)
    shape = heat_film(made, PredictOptions(device="cpu"))
    z = shape.hot_mm[:, 2]
    depth = np.maximum(PLATE_REACH_MM - z, 0.0)
    carried = float((made.vertex_area_mm2 * PLATE_PER_MM * depth**2 / (2.0 * PLATE_REACH_MM)).sum())
    weight = 1.1772e-5 * 0.8 / (0.5 / 3)
    assert carried == pytest.approx(weight * made.area_mm2.sum(), rel=1e-6)
    assert z.min() > -1e-3
    assert z.max() > 1.0


def test_ramp_starts_flat_and_reaches_its_tolerance():
    made = film(rectangle(10.0, 12.0), 1.0, contraction=0.2)
    shape = heat_film(made, PredictOptions(support="free", device="cpu"))
    assert shape.temperature_c[0] == pytest.approx(25.0)
    assert shape.temperature_c[-1] == pytest.approx(150.0)
    assert len(shape.temperature_c) >= 7
    assert np.all(np.diff(shape.temperature_c) > 0)
    assert np.ptp(shape.vertices_mm[0][:, 2]) < 1e-9
    assert shape.relative_residual <= 1e-9
    assert shape.stable


@pytest.mark.parametrize("support", ["free", "plate"])
def test_coarse_to_fine_gives_the_shape_of_the_plain_ramp(support, monkeypatch):
    monkeypatch.setattr("twin.predict.COARSEST_TRIANGLES", 200)
    made = film(ellipse(12.0, 9.0), 0.7, contraction=0.15, direction=azimuthal)
    options = PredictOptions(support=support, device="cpu")
    short, plain = heat_film(made, options), heat_film(made, replace(options, coarse_to_fine=False))
    assert len(made.triangles) > 800
    assert short.energy_mj == pytest.approx(plain.energy_mj, rel=1e-9)
    assert rigid_distance_mm(short.hot_mm, plain.hot_mm) < 1e-5
    assert short.relative_residual <= 1e-9
    assert len(short.temperature_c) >= 7


def test_coarse_film_keeps_area_and_alignment():
    made = film(ellipse(12.0, 9.0), 0.5, contraction=0.15, direction=azimuthal)
    coarse = coarsen(made, 1.0)
    assert 0.2 < len(coarse.triangles) / len(made.triangles) < 0.35
    assert coarse.area_mm2.sum() == pytest.approx(made.area_mm2.sum(), rel=0.01)
    away = np.hypot(*coarse.flat_mm[coarse.triangles].mean(axis=1).T) > 2.0
    np.testing.assert_allclose(coarse.contraction[0, away], 0.15, rtol=0.02)
    np.testing.assert_array_equal(coarse.contraction[2:], 0.0)


def test_carried_shapes_are_exact_for_planes_and_smooth_for_bends():
    source = film(ellipse(12.0, 9.0), 1.0).flat_mm
    fine = film(ellipse(12.0, 9.0), 0.5).flat_mm
    plane = np.column_stack((source, 2.0 + 0.3 * source[:, 0] - 0.1 * source[:, 1]))
    carried = carry(source, plane, fine)
    np.testing.assert_allclose(carried[:, 2], 2.0 + 0.3 * fine[:, 0] - 0.1 * fine[:, 1], atol=1e-6)
    bend = carry(source, np.cos(source[:, :1] / 4.0), fine)
    np.testing.assert_allclose(bend[:, 0], np.cos(fine[:, 0] / 4.0), atol=0.02)


def test_same_seed_same_shape():
    made = film(rectangle(8.0, 8.0), 1.0, contraction=0.2, direction=azimuthal)
    options = PredictOptions(support="free", device="cpu", seed=7)
    np.testing.assert_array_equal(heat_film(made, options).hot_mm, heat_film(made, options).hot_mm)


def test_solver_says_where_it_stopped():
    made = film(rectangle(8.0, 8.0), 1.0, contraction=0.3)
    shell = Shell(made, device="cpu")
    newton = Newton(shell, rigid_pins(made.flat_mm, on_plate=False), NewtonOptions(max_iterations=1))
    with pytest.raises(SolverError, match="no equilibrium found beyond"):
        heat(newton, 1.0, rng=np.random.default_rng(0), options=RampOptions(first_step=1.0))


@pytest.mark.parametrize("kind", [PardisoSolver, SuperLuSolver])
def test_sparse_solvers_agree_and_see_indefinite_matrices(kind):
    if kind is PardisoSolver and not HAVE_PARDISO:
        pytest.skip("MKL PARDISO is not published for this platform")
    rng = np.random.default_rng(0)
    root = sp.random(60, 60, density=0.1, random_state=rng).tocsr()
    matrix = (root @ root.T + sp.eye(60)).tocsr()
    upper = sp.triu(matrix).tocsr()
    upper.sort_indices()
    solver = kind(upper.indptr, upper.indices)
    right = rng.normal(size=60)
    assert solver.factorize(upper.data.copy())
    np.testing.assert_allclose(matrix @ solver.solve(right), right, atol=1e-12)
    indefinite = upper.copy()
    indefinite.data[indefinite.indptr[10]] = -5.0
    assert not solver.factorize(indefinite.data.copy())
    assert solver.factorize(upper.data.copy())
    np.testing.assert_allclose(matrix @ solver.solve(right), right, atol=1e-12)
    solver.close()


def test_default_solver_is_the_fast_one_where_it_exists():
    made = sparse_solver(np.array([0, 1]), np.array([0]))
    assert isinstance(made, PardisoSolver if HAVE_PARDISO else SuperLuSolver)
    made.close()
