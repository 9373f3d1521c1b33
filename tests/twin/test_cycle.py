"""Heating and cooling, and the families of shapes that several seeds find."""

import numpy as np
import pytest
from films import azimuthal, ellipse, film, rectangle
from scipy.spatial.transform import Rotation

from twin.cycle import back_to_flat_mm, cooled, rigid_distance_mm
from twin.families import shapes_by_seed
from twin.predict import PredictOptions, heat_film


@pytest.mark.parametrize("support", ["free", "plate"])
def test_cooled_film_is_flat_again(support):
    made = film(ellipse(10.0, 8.0), 1.0, contraction=0.15, direction=azimuthal)
    options = PredictOptions(support=support, device="cpu")
    shape, plain = heat_film(made, cooled(options)), heat_film(made, options)
    assert [stop.temperature_c for stop in shape.stops] == [150.0, 25.0]
    assert back_to_flat_mm(shape) < 1e-3
    assert back_to_flat_mm(plain) is None
    assert np.ptp(shape.vertices_mm[-1][:, 2]) < 1e-3
    np.testing.assert_array_equal(shape.hot_mm, plain.hot_mm)
    np.testing.assert_array_equal(shape.top_mm, plain.top_mm)
    assert shape.snaps == ()


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
