"""Layers whose thickness varies over the film, and layers cut into sublayers."""

from dataclasses import replace

import numpy as np
import pytest
from films import azimuthal, ellipse, film, random_film, rectangle

from twin.film import Film, coarsen
from twin.predict import PLATE_PER_MM, PLATE_REACH_MM, PredictOptions, film_loads, heat_film
from twin.shell import Shell, rest_state

ACTIVATION = 0.8


def varying(made: Film, layer_thickness_mm: np.ndarray) -> Film:
    return replace(made, layer_thickness_mm=layer_thickness_mm)


def repeated(made: Film, parts_mm: list[np.ndarray | float]) -> Film:
    """The film with layer 1 cut into parts of the given thicknesses, bottom first."""
    count = len(made.triangles)
    layers = [0, *[1] * len(parts_mm), 2, 3]
    thickness = np.full((len(layers), count), 0.2)
    thickness[1 : 1 + len(parts_mm)] = [np.broadcast_to(part, count) for part in parts_mm]
    return Film(
        flat_mm=made.flat_mm,
        triangles=made.triangles,
        layer_thickness_mm=thickness,
        director_rad=made.director_rad[layers],
        contraction=made.contraction[layers],
        modulus_ratio=made.modulus_ratio[layers],
    )


def test_one_thickness_a_triangle_is_the_same_as_one_a_layer():
    made = random_film(np.random.default_rng(3))[0].film
    wide = varying(made, np.repeat(made.layer_thickness_mm[:, None], len(made.triangles), axis=1))
    one, other = rest_state(made, ACTIVATION), rest_state(wide, ACTIVATION)
    for name in ("moments", "point_z_mm", "point_c", "constant", "top_mm"):
        np.testing.assert_allclose(getattr(other, name), getattr(one, name), rtol=1e-14, atol=1e-15)
    assert wide.thickness_mm == pytest.approx(0.8)


def test_each_triangle_has_the_rest_state_of_its_own_thickness():
    made = random_film(np.random.default_rng(4))[0].film
    rng = np.random.default_rng(5)
    thickness = rng.uniform(0.05, 0.4, size=(4, len(made.triangles)))
    found = rest_state(varying(made, thickness), ACTIVATION)
    for t in (0, 7, 20):
        alone = rest_state(varying(made, thickness[:, t]), ACTIVATION)
        np.testing.assert_allclose(found.moments[t], alone.moments[t], rtol=1e-13, atol=1e-16)
        np.testing.assert_allclose(found.point_z_mm[t], alone.point_z_mm[t], rtol=1e-13, atol=1e-16)
        assert found.top_mm[t] == pytest.approx(alone.top_mm[t])


def test_a_layer_cut_in_two_prescribes_the_same():
    """Two points a sublayer integrate the moments exactly, whatever the cut; the energy differs at higher order."""
    made = random_film(np.random.default_rng(6))[0].film
    below = np.random.default_rng(7).uniform(0.02, 0.18, size=len(made.triangles))
    one, cut = rest_state(made, ACTIVATION), rest_state(repeated(made, [below, 0.2 - below]), ACTIVATION)
    np.testing.assert_allclose(cut.moments, one.moments, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(cut.point_c.sum(axis=1), one.point_c.sum(axis=1), rtol=1e-13)
    np.testing.assert_allclose(cut.top_mm, one.top_mm, rtol=1e-13)
    assert cut.point_z_mm.shape == (len(made.triangles), 10)


def test_a_sublayer_without_thickness_changes_nothing():
    shell, state = random_film(np.random.default_rng(8), activation=ACTIVATION)
    more = Shell(repeated(shell.film, [0.0, 0.2, 0.0]), device="cpu")
    more.set_activation(ACTIVATION)
    assert more.energy(state) == pytest.approx(shell.energy(state), rel=1e-12)
    np.testing.assert_allclose(more.gradient(state)[1], shell.gradient(state)[1], rtol=1e-9, atol=1e-12)


def test_thickness_of_a_wedge_is_its_mean():
    made = film(rectangle(6.0, 4.0), 0.5)
    x = made.flat_mm[made.triangles].mean(axis=1)[:, 0]
    wedge = varying(made, np.full((4, 1), 0.25) * (0.8 + 0.1 * x))
    assert wedge.thickness_mm == pytest.approx(0.8, rel=1e-9)


def test_coarse_film_keeps_volume_and_alignment_of_varying_layers():
    made = film(ellipse(10.0, 8.0), 0.5, contraction=0.2, direction=azimuthal)
    radius = np.hypot(*made.flat_mm[made.triangles].mean(axis=1).T)
    thickness = np.full((4, len(made.triangles)), 0.2)
    thickness[0] = np.where(radius < 5.0, 0.0, 0.1)
    made = varying(made, thickness)
    coarse = coarsen(made, 1.0)
    assert coarse.layer_thickness_mm.shape == (4, len(coarse.triangles))
    assert coarse.layer_thickness_mm[0] @ coarse.area_mm2 == pytest.approx(thickness[0] @ made.area_mm2, rel=0.01)
    np.testing.assert_allclose(coarse.layer_thickness_mm[1:], 0.2)
    # what has no thickness does not dilute the alignment of what has
    aligned = (coarse.layer_thickness_mm[0] > 0.0) & (np.hypot(*coarse.flat_mm[coarse.triangles].mean(axis=1).T) > 4.0)
    np.testing.assert_allclose(coarse.contraction[0, aligned], 0.2, rtol=0.02)


def test_a_wedge_is_heavier_where_it_is_thicker():
    made = film(rectangle(6.0, 4.0), 0.5)
    x = made.flat_mm[made.triangles].mean(axis=1)[:, 0]
    wedge = varying(made, np.full((4, 1), 0.25) * (0.8 + 0.1 * x))
    options = PredictOptions(device="cpu")
    weight, even = film_loads(wedge, options).weight, film_loads(made, options).weight
    inside = np.abs(made.flat_mm[:, 0]) < 2.5
    expected = even * (0.8 + 0.1 * made.flat_mm[inside, 0]) / 0.8
    np.testing.assert_allclose(weight[inside], expected, rtol=0.02)
    assert weight @ made.vertex_area_mm2 == pytest.approx(even * made.area_mm2.sum(), rel=1e-9)
    # the plate carries each vertex's own weight: the wedge rests where its load is
    shape = heat_film(wedge, options)
    depth = np.maximum(PLATE_REACH_MM - shape.hot_mm[:, 2], 0.0)
    carried = made.vertex_area_mm2 * PLATE_PER_MM * depth**2 / (2.0 * PLATE_REACH_MM)
    assert carried.sum() == pytest.approx((weight * made.vertex_area_mm2).sum(), rel=1e-6)
    assert carried @ made.flat_mm[:, 0] == pytest.approx((weight * made.vertex_area_mm2) @ made.flat_mm[:, 0], rel=1e-5)
