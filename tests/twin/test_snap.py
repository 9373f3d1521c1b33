"""Jumps of a film while it is heated or cooled, and the temperatures that it passes through."""

import numpy as np
import pytest
from films import azimuthal, ellipse, film, rectangle

from planner.errors import InputError
from twin.cycle import back_to_flat_mm, cooled, hysteresis_mm
from twin.equilibrium.snap import departs
from twin.material import Material
from twin.predict import PredictOptions, heat_film
from twin.temperature import TemperatureGapModel

CONE = film(ellipse(12.0, 12.0), 1.6, layers=(0, 1, 2, 3), contraction=0.15, direction=azimuthal)
"""On the plate its weight holds it flat until it is tapped; once a cone, it stays one far below that temperature."""


def test_cone_on_the_plate_snaps_flat_when_it_is_cooled():
    shape = heat_film(CONE, PredictOptions(temperatures_c=(80.0, 150.0, 80.0, 25.0), device="cpu"))
    assert len(shape.tapped_away_at_c) == 1
    assert shape.tapped_away_at_c[0] > 80.0
    (snap,) = shape.snaps
    assert snap.cooling
    assert 40.0 < snap.temperature_c < 80.0
    assert snap.distance_mm > 0.5
    assert shape.snapped_at_c == (snap.temperature_c,)
    assert hysteresis_mm(shape) == {80.0: pytest.approx(np.ptp(shape.vertices_mm[shape.stops[2].index][:, 2]), rel=0.5)}
    assert back_to_flat_mm(shape) < 1e-3


def test_weightless_cone_rises_and_comes_back_by_the_same_way():
    shape = heat_film(CONE, PredictOptions(temperatures_c=(80.0, 150.0, 80.0, 25.0), support="free", device="cpu"))
    assert shape.snaps == ()
    assert np.ptp(shape.hot_mm[:, 2]) > 2.0
    assert hysteresis_mm(shape)[80.0] < 1e-4
    assert back_to_flat_mm(shape) < 1e-3


def test_soft_arch_snaps_while_it_is_heated():
    made = film(rectangle(30.0, 18.0), 1.6, contraction=0.15)
    shape = heat_film(made, PredictOptions(material=Material(modulus_mpa=0.2), device="cpu"))
    assert shape.snaps
    assert shape.snaps[0].distance_mm > 1.0
    assert not any(snap.cooling for snap in shape.snaps)
    assert shape.stable


def test_steps_that_go_as_expected_are_not_asked_back():
    before, way = np.zeros((4, 3)), np.tile((0.0, 0.0, 1.0), (4, 1))
    assert not departs(before, way, 1.2 * way)
    assert departs(before, way, 1.4 * way)
    assert departs(before, None, way)
    assert not departs(before, None, 0.009 * way)


@pytest.mark.parametrize("field", [None, TemperatureGapModel()])
def test_film_passes_exactly_through_the_temperatures_asked_for(field):
    made = film(ellipse(8.0, 6.0), 1.4, contraction=0.12, direction=azimuthal)
    asked = (25.0, 60.0, 105.0, 150.0, 130.0, 105.0, 25.0)
    extra = {} if field is None else {"temperature_field": field}
    shape = heat_film(made, PredictOptions(temperatures_c=asked, device="cpu", **extra))
    assert tuple(stop.temperature_c for stop in shape.stops) == asked
    assert [shape.temperature_c[stop.index] for stop in shape.stops] == list(asked)
    assert shape.hottest == shape.stops[3].index
    assert all(stop.stable and stop.relative_residual <= 1e-9 for stop in shape.stops)
    depth = [np.ptp(shape.vertices_mm[stop.index][:, 2]) for stop in shape.stops]
    assert depth[0] < 1e-6
    assert depth[1] < depth[2] < depth[3]
    assert depth[5] == pytest.approx(depth[2], abs=1e-3)
    assert back_to_flat_mm(shape) < 1e-3
    plain = heat_film(made, PredictOptions(device="cpu", **extra))
    np.testing.assert_allclose(shape.hot_mm, plain.hot_mm, atol=2e-3 if field else 1e-6)


def test_stops_of_a_fine_film_are_solved_on_its_own_mesh(monkeypatch):
    monkeypatch.setattr("twin.predict.COARSEST_TRIANGLES", 60)
    made = film(ellipse(8.0, 6.0), 0.8, contraction=0.12, direction=azimuthal)
    assert len(made.triangles) > 240
    shape = heat_film(made, PredictOptions(temperatures_c=(100.0, 150.0, 100.0), device="cpu"))
    assert all(stop.relative_residual <= 1e-9 for stop in shape.stops)
    assert hysteresis_mm(shape)[100.0] < 1e-5


def test_a_film_that_stays_cold_stays_flat():
    made = film(ellipse(8.0, 6.0), 1.6, contraction=0.12, direction=azimuthal)
    shape = heat_film(made, PredictOptions(temperature_c=25.0, device="cpu"))
    assert shape.temperature_c[shape.hottest] == 25.0
    assert np.ptp(shape.hot_mm[:, 2]) < 1e-6


@pytest.mark.parametrize(
    ("asked", "told"), [((), "found none"), ((60.0, 20.0), "found 20 C"), ((float("nan"),), "found nan C")]
)
def test_wrong_temperatures_are_refused(asked, told):
    with pytest.raises(InputError, match=told):
        heat_film(CONE, PredictOptions(temperatures_c=asked))


def test_cooled_adds_the_room_to_what_was_asked():
    assert cooled(PredictOptions()).temperatures_c == (150.0, 25.0)
    assert cooled(PredictOptions(temperatures_c=(60.0, 90.0))).temperatures_c == (60.0, 90.0, 25.0)
