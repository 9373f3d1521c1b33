"""The shell's energy and derivatives: against finite differences, invariances, an independent program."""

import numpy as np
import pytest
import scipy.sparse as sp
from films import film, random_film, rectangle, reference_shell
from scipy.spatial.transform import Rotation

from twin.shell import Loads, Shell
from twin.shell.topology import stencils

LOADS = Loads(weight=5.65e-5, plate_per_mm=1.0, plate_reach_mm=0.2)


def full_hessian(shell: Shell, state: np.ndarray, *, clamp: bool = False) -> np.ndarray:
    values = shell.hessian(state, clamp=clamp)[2]
    size = 3 * shell.vertex_count
    upper = sp.csr_matrix((values, shell.pattern.indices, shell.pattern.indptr), shape=(size, size))
    return (upper + sp.triu(upper, 1).T).toarray()


@pytest.mark.parametrize("loads", [None, LOADS], ids=["free", "plate"])
def test_gradient_agrees_with_finite_differences(loads):
    rng = np.random.default_rng(1)
    shell, state = random_film(rng, loads=loads)
    gradient = shell.gradient(state)[1]
    direction = rng.normal(size=state.shape)
    step = 1e-5
    slope = (shell.energy(state + step * direction) - shell.energy(state - step * direction)) / (2 * step)
    scale = np.linalg.norm(gradient) * np.linalg.norm(direction)
    assert slope == pytest.approx(float((gradient * direction).sum()), abs=1e-8 * scale)


@pytest.mark.parametrize("loads", [None, LOADS], ids=["free", "plate"])
def test_hessian_agrees_with_finite_differences(loads):
    rng = np.random.default_rng(2)
    shell, state = random_film(rng, loads=loads)
    hessian = full_hessian(shell, state)
    direction = rng.normal(size=state.shape)
    step = 1e-6
    change = (shell.gradient(state + step * direction)[1] - shell.gradient(state - step * direction)[1]) / (2 * step)
    np.testing.assert_allclose(hessian @ direction.ravel(), change.ravel(), atol=1e-7 * np.abs(change).max())
    np.testing.assert_array_equal(hessian, hessian.T)


def test_clamped_hessian_is_positive_semi_definite_where_the_exact_one_is_not():
    shell, state = random_film(np.random.default_rng(3))
    state = state * (0.8, 0.8, 0.1)  # nearly flat and compressed: it wants to buckle
    exact = np.linalg.eigvalsh(full_hessian(shell, state))
    clamped = np.linalg.eigvalsh(full_hessian(shell, state, clamp=True))
    assert exact[0] < -1e-6 * exact[-1]
    assert clamped[0] > -1e-12 * clamped[-1]


def test_rigid_motion_changes_nothing():
    shell, state = random_film(np.random.default_rng(4))
    turn = Rotation.from_rotvec([0.3, -1.1, 0.7])
    energy, gradient = shell.gradient(state)
    moved_energy, moved_gradient = shell.gradient(turn.apply(state) + np.array([3.0, -2.0, 5.0]))
    assert moved_energy == pytest.approx(energy, rel=1e-12)
    np.testing.assert_allclose(moved_gradient, turn.apply(gradient), atol=1e-11)
    # no net force and no net moment
    np.testing.assert_allclose(gradient.sum(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.cross(state, gradient).sum(axis=0), 0.0, atol=1e-11)


def test_energy_is_zero_at_rest_and_positive_elsewhere():
    rest = film(rectangle(5.0, 4.0), 1.0)
    shell = Shell(rest, device="cpu")
    flat = np.column_stack((rest.flat_mm, np.zeros(len(rest.flat_mm))))
    assert shell.energy(flat) == pytest.approx(0.0, abs=1e-13)
    rng = np.random.default_rng(5)
    for _ in range(5):
        assert shell.energy(flat + 0.1 * rng.normal(size=flat.shape)) > 0.0


def test_uniform_contraction_of_all_layers_is_stress_free():
    """A film whose four layers agree shrinks by 1 - e along and grows by (1 - e)^(-1/2) across, at no energy."""
    made = film(rectangle(5.0, 4.0), 1.0, layers=(0, 1, 2, 3), contraction=0.3)
    shell = Shell(made, device="cpu")
    shell.set_activation(1.0)
    shrunk = np.column_stack((0.7 * made.flat_mm[:, 0], made.flat_mm[:, 1] / np.sqrt(0.7), 0.0 * made.flat_mm[:, 0]))
    energy, gradient = shell.gradient(shrunk)
    assert energy == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(gradient, 0.0, atol=1e-12)


def test_film_folded_through_its_thickness_has_infinite_energy():
    made = film(rectangle(4.0, 4.0), 0.5)
    shell = Shell(made, device="cpu")
    x, y = made.flat_mm.T
    radius = 0.25  # less than half the thickness: the inner face would turn inside out
    assert shell.energy(np.column_stack((radius * np.sin(x / radius), y, radius * np.cos(x / radius)))) == np.inf


def test_results_do_not_depend_on_the_number_of_threads():
    made = film(rectangle(30.0, 20.0), 0.6, contraction=0.2)
    state = np.column_stack((made.flat_mm, 0.1 * np.sin(made.flat_mm[:, 0])))
    one, many = Shell(made, device="cpu", threads=1), Shell(made, device="cpu", threads=4)
    for shell in (one, many):
        shell.set_activation(0.7)
    for left, right in zip(one.hessian(state), many.hessian(state), strict=True):
        np.testing.assert_array_equal(left, right)


def test_stencils_refuse_a_non_manifold_mesh():
    with pytest.raises(ValueError, match="non-manifold"):
        stencils(np.array([[0, 1, 2], [0, 1, 3]]))


@pytest.mark.shared
@pytest.mark.parametrize("name", ["disc_azimuthal", "strip_wide", "four_layers_free", "film_on_plate"])
def test_energy_and_gradient_agree_with_an_independent_program(shared_dir, name):
    data = np.load(shared_dir / "reference" / f"{name}.npz")
    shell = reference_shell(data, name)
    energy, gradient = shell.gradient(data["perturbed_mm"])
    assert energy == pytest.approx(float(data["energy_perturbed"]), rel=1e-9)
    scale = np.abs(data["gradient_perturbed"]).max()
    np.testing.assert_allclose(gradient, data["gradient_perturbed"], atol=1e-9 * scale)
    assert shell.energy(data["equilibrium_mm"]) == pytest.approx(float(data["energy_equilibrium"]), rel=1e-9)
