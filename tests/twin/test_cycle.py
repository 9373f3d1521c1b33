"""Heating and cooling, and the families of shapes that several seeds find."""

import numpy as np
import pytest
from films import azimuthal, ellipse, film, rectangle
from scipy.spatial.transform import Rotation

from twin.cycle import Cycle, heat_and_cool, rigid_distance_mm
from twin.families import shapes_by_seed
from twin.predict import PredictOptions


@pytest.mark.parametrize("support", ["free", "plate"])
def test_cooled_film_is_flat_again(support):
    made = film(ellipse(10.0, 8.0), 1.0, contraction=0.15, direction=azimuthal)
    cycle = heat_and_cool(made, PredictOptions(support=support, device="cpu"))
    assert cycle.back_to_flat_mm < 1e-3
    assert np.ptp(cycle.cooled_mm[0][:, 2]) < 1e-3
    assert np.ptp(cycle.heated_mm[-1][:, 2]) > 1.0
    np.testing.assert_array_equal(cycle.heated_mm[-1], cycle.cooled_mm[-1])
    assert cycle.snaps_between_c == ()


def test_snaps_are_the_ranges_where_the_paths_differ():
    states = np.zeros((6, 4, 3))
    difference = np.array([0.0, 0.0, 0.4, 0.5, 0.0, 0.2])
    temperature = np.array([25.0, 60.0, 80.0, 100.0, 110.0, 120.0])
    cycle = Cycle(temperature_c=temperature, heated_mm=states, cooled_mm=states, difference_mm=difference)
    assert cycle.snaps_between_c == ((80.0, 100.0), (120.0, 120.0))


def test_cone_of_four_alike_layers_pops_up_or_down_by_the_seed():
    """Nothing but the disturbance tells such a film which side is up: the two cones are mirror images."""
    made = film(ellipse(8.0, 8.0), 1.0, layers=(0, 1, 2, 3), contraction=0.15, direction=azimuthal)
    families = shapes_by_seed(made, PredictOptions(support="free", device="cpu"), 6)
    assert len(families) == 2
    assert sum(family.share for family in families) == pytest.approx(1.0)
    assert sorted(seed for family in families for seed in family.seeds) == list(range(6))
    up, down = (family.shape for family in families)
    assert up.energy_mj == pytest.approx(down.energy_mj, rel=1e-6)


def test_bottom_bent_film_has_one_shape():
    made = film(rectangle(8.0, 8.0), 1.0, contraction=0.15)
    (family,) = shapes_by_seed(made, PredictOptions(support="free", device="cpu"), 3)
    assert family.share == 1.0


def test_rigid_distance_ignores_motion_but_not_reflection():
    shape = np.random.default_rng(0).normal(size=(20, 3))
    moved = Rotation.from_rotvec([1.0, 2.0, -0.5]).apply(shape) + np.array([3.0, 0.0, 1.0])
    assert rigid_distance_mm(shape, moved) < 1e-12
    assert rigid_distance_mm(shape, shape * (1.0, 1.0, -1.0)) > 0.1
