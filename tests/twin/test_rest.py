"""The rest state: metrics, heights and weights of the layers, and their energy, against a few lines of NumPy."""

import dataclasses

import numpy as np
import pytest
from films import PAPER_STACK_MM, film, rectangle

from planner.target import mesh_outline
from twin.film import Film, film_from_alignment
from twin.shell import Shell
from twin.shell.rest import rest_state

SPOT = 0.5 / np.sqrt(3.0)
"""Distance of a Gauss point from its layer's middle, in thicknesses."""


def one_triangle(director_rad, contraction, thickness_mm=PAPER_STACK_MM, modulus_ratio=None) -> Film:
    layers = len(thickness_mm)
    return Film(
        flat_mm=np.array([[0.2, -0.1], [1.3, 0.3], [0.4, 1.1]]),
        triangles=np.array([[0, 1, 2]]),
        layer_thickness_mm=np.array(thickness_mm),
        director_rad=np.broadcast_to(np.asarray(director_rad, dtype=float), layers)[:, None],
        contraction=np.broadcast_to(np.asarray(contraction, dtype=float), layers)[:, None],
        modulus_ratio=np.ones(layers) if modulus_ratio is None else np.array(modulus_ratio),
    )


def metric(contraction: float, director_rad: float) -> np.ndarray:
    """Spontaneous metric R diag(lambda^2, 1 / lambda) R^t."""
    cos, sin = np.cos(director_rad), np.sin(director_rad)
    turn = np.array([[cos, -sin], [sin, cos]])
    return turn @ np.diag([(1 - contraction) ** 2, 1 / (1 - contraction)]) @ turn.T


def density(rest_metric: np.ndarray, hot_metric: np.ndarray) -> float:
    """Incompressible neo-classical energy over mu, for each flat volume."""
    volume = np.linalg.det(rest_metric) / np.linalg.det(hot_metric)
    return 0.5 * float(np.trace(np.linalg.solve(rest_metric, hot_metric)) + volume - 3.0)


def heights(thickness_mm, contraction) -> tuple[np.ndarray, float]:
    """Gauss points of the hot stack, shape [layers, 2], and its top [mm], counted from where the flat middle went."""
    middle, points, hot_bottom, flat_bottom = 0.0, [], 0.0, 0.0
    for thick, e in zip(thickness_mm, contraction, strict=True):
        swell = (1 - e) ** -0.5
        points.append([hot_bottom + swell * thick * (0.5 - SPOT), hot_bottom + swell * thick * (0.5 + SPOT)])
        if flat_bottom <= sum(thickness_mm) / 2 < flat_bottom + thick:
            middle = hot_bottom + swell * (sum(thickness_mm) / 2 - flat_bottom)
        hot_bottom, flat_bottom = hot_bottom + swell * thick, flat_bottom + thick
    return np.array(points) - middle, hot_bottom - middle


@pytest.mark.parametrize("activation", [0.0, 0.6, 1.0])
def test_one_flat_triangle_has_the_energy_of_the_books(activation):
    """Without bending G = a: W = area sum over layers of h/2 mu (tr(A^-1 a) + det A / det a - 3)."""
    contraction, director = np.array([0.3, 0.1, 0.0, 0.2]), np.array([0.2, 1.1, 0.0, -0.7])
    thickness, ratio = (0.2, 0.1, 0.3, 0.15), (1.0, 0.5, 2.0, 1.5)
    made = one_triangle(director, contraction, thickness, ratio)
    shell = Shell(made, device="cpu")
    shell.set_activation(activation)
    stretch = np.array([[1.1, 0.15], [-0.05, 0.9]])
    flat = np.column_stack((made.flat_mm @ stretch.T, np.zeros(3)))
    wanted = made.area_mm2[0] * sum(
        h * mu * density(metric(activation * e, angle), stretch.T @ stretch)
        for h, mu, e, angle in zip(thickness, ratio, contraction, director, strict=True)
    )
    assert shell.energy(flat) == pytest.approx(wanted, rel=1e-12)


def test_a_rest_metric_has_no_energy():
    made = one_triangle(0.4, 0.35)
    shell = Shell(made, device="cpu")
    shell.set_activation(1.0)
    root = np.linalg.cholesky(metric(0.35, 0.4)).T
    assert shell.energy(np.column_stack((made.flat_mm @ root.T, np.zeros(3)))) == pytest.approx(0.0, abs=1e-15)


def bent_by_hand(radius_mm: float, contraction, director) -> float:
    """Energy over mu for each flat area of the paper's stack bent to a cylinder around y: G = diag((1 + z/R)^2, 1)."""
    spots, _ = heights(PAPER_STACK_MM, contraction)
    return sum(
        0.5 * thick * density(metric(e, angle), np.diag([(1 + z / radius_mm) ** 2, 1.0]))
        for thick, e, angle, pair in zip(PAPER_STACK_MM, contraction, director, spots, strict=True)
        for z in pair
    )


def bent_by_shell(radius_mm: float, contraction, director, mesh_mm: float) -> float:
    """The same of a strip of triangles."""
    flat, triangles = mesh_outline(rectangle(6.0, 6.0), mesh_mm)
    q = np.stack(
        [e * np.array([np.cos(2 * angle), np.sin(2 * angle)]) for e, angle in zip(contraction, director, strict=True)]
    )
    q = np.repeat(q[:, None], len(triangles), axis=1)
    made = film_from_alignment(flat, triangles, q, layer_thickness_mm=np.array(PAPER_STACK_MM))
    shell = Shell(made, device="cpu")
    shell.set_activation(1.0)
    x, y = flat.T
    cylinder = np.column_stack((radius_mm * np.sin(x / radius_mm), y, radius_mm * np.cos(x / radius_mm)))
    return shell.energy(cylinder) / made.area_mm2.sum()


@pytest.mark.parametrize("radius_mm", [3.0, 15.0, -5.0])
@pytest.mark.parametrize(
    ("contraction", "director"),
    [((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)), ((0.3, 0.2, 0.1, 0.0), (0.0, 0.6, 1.2, 0.0))],
    ids=["polydomain", "four layers"],
)
def test_bending_to_a_cylinder_costs_what_the_layers_say(radius_mm, contraction, director):
    wanted = bent_by_hand(radius_mm, contraction, director)
    coarse, fine = (bent_by_shell(radius_mm, contraction, director, mesh_mm) for mesh_mm in (0.4, 0.1))
    assert fine == pytest.approx(wanted, rel=0.03)
    # at least first order: an edge of the free border knows the bending of one side only
    assert abs(fine - wanted) < 0.35 * abs(coarse - wanted)


STACKS = {
    "four layers, bottom two": ((0.2, 0.2, 0.2, 0.2), (0.3, 0.3, 0.0, 0.0)),
    "four layers, top two": ((0.2, 0.2, 0.2, 0.2), (0.0, 0.0, 0.4, 0.4)),
    "two layers": ((0.2, 0.2), (0.25, 0.0)),
    "three layers, the middle one split": ((0.2, 0.2, 0.2), (0.3, 0.1, 0.0)),
    "one thick layer below": ((0.5, 0.1), (0.2, 0.0)),
    "five unequal layers": ((0.1, 0.3, 0.2, 0.1, 0.25), (0.4, 0.3, 0.2, 0.1, 0.0)),
}


@pytest.mark.parametrize(("thickness_mm", "contraction"), STACKS.values(), ids=STACKS)
def test_gauss_points_lie_in_the_hot_stress_free_stack(thickness_mm, contraction):
    rest = rest_state(one_triangle(0.0, contraction, thickness_mm), 1.0)
    points, top = heights(thickness_mm, contraction)
    np.testing.assert_allclose(np.sort(rest.point_z_mm[0]), np.sort(points.ravel()), atol=1e-15)
    assert rest.top_mm[0] == pytest.approx(top, abs=1e-15)


def test_heights_of_the_papers_stack_by_hand():
    """lambda = 0.64: the contracting layers are 0.2 / 0.8 = 0.25 mm thick and lie below z = 0, the others as flat."""
    rest = rest_state(one_triangle(0.0, (0.36, 0.36, 0.0, 0.0)), 1.0)
    below, above = 0.25 * SPOT, 0.2 * SPOT
    wanted = [-0.375 - below, -0.375 + below, -0.125 - below, -0.125 + below]
    wanted += [0.1 - above, 0.1 + above, 0.3 - above, 0.3 + above]
    np.testing.assert_allclose(np.sort(rest.point_z_mm[0]), wanted, atol=1e-15)
    assert rest.top_mm[0] == pytest.approx(0.4)


def test_weights_are_those_of_the_flat_layers():
    """M0 = sum over layers of h/2 A^-1, so that of a polydomain film is H/2 of the identity, and M1 vanishes."""
    rest = rest_state(one_triangle(0.0, 0.0), 1.0)
    np.testing.assert_allclose(rest.moments[0, 0], [0.4, 0.0, 0.4], atol=1e-15)
    np.testing.assert_allclose(rest.moments[0, 1], 0.0, atol=1e-15)
    # second moment of a plate, H^3 / 12, halved
    np.testing.assert_allclose(rest.moments[0, 2], [0.8**3 / 24, 0.0, 0.8**3 / 24], atol=1e-15)
    assert rest.constant[0] == pytest.approx(1.5 * 0.8)
    # incompressible: det A of a contracting layer is lambda, whatever its direction
    contracted = rest_state(one_triangle((0.1, 0.5, 0.9, 1.3), 0.3), 1.0)
    np.testing.assert_allclose(contracted.point_c, 0.7 * 0.05, atol=1e-15)


def test_each_triangle_may_have_its_own_activation():
    made = film(rectangle(4.0, 4.0), 1.0, contraction=0.3)
    half = np.linspace(0.0, 1.0, len(made.triangles))
    mixed = rest_state(made, half)
    for place in (0, len(half) // 2, -1):
        one = rest_state(made, float(half[place]))
        for field in dataclasses.fields(mixed):
            np.testing.assert_array_equal(getattr(mixed, field.name)[place], getattr(one, field.name)[place])


def test_contraction_to_nothing_is_refused():
    with pytest.raises(ValueError, match="must stay below 1"):
        rest_state(one_triangle(0.0, 1.0), 1.0)
