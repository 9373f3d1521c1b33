"""The hot-air gun and the hot plate: a heater that behaves, and every way in which one does not."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.errors import InputError, RigError
from rig.devices import HotAir, HotPlate
from rig.heated_device import HeatedDevice
from rig.heating_watch import HeatingLimits
from rig.transport import VirtualClock
from rig.virtual.heater import VirtualHeater
from rig.virtual.thermostat import SimulatedThermostat


def plate(heater: VirtualHeater) -> tuple[HeatedDevice, VirtualClock]:
    clock = VirtualClock()
    device = HeatedDevice(
        SimulatedThermostat(heater, clock), clock, name="hot plate", temperature_c_max=200.0, limits=HeatingLimits()
    )
    return device, clock


def test_it_is_a_hot_plate_and_a_hot_air_gun() -> None:
    device, _ = plate(VirtualHeater())
    assert isinstance(device, HotPlate)
    assert isinstance(device, HotAir)


def test_it_becomes_warm_stays_so_and_cools() -> None:
    heater = VirtualHeater()
    device, clock = plate(heater)
    device.set_temperature(150.0)
    device.wait_temperature(600.0)
    assert 128 / heater.rate_c_s < clock.now_s() < 300
    for _ in range(60):
        clock.sleep(60.0)
        assert device.temperature_c() == pytest.approx(150.0, abs=2.5)
    assert heater.hottest_c < 151
    device.turn_off()
    clock.sleep(3600.0)
    assert device.temperature_c() == pytest.approx(22.0, abs=0.1)
    assert heater.target_c is None


def test_the_same_temperature_again_changes_nothing_and_a_lower_one_waits_for_cooling() -> None:
    heater = VirtualHeater()
    device, clock = plate(heater)
    device.set_temperature(150.0)
    device.wait_temperature(600.0)
    device.set_temperature(150.0)
    before_s = clock.now_s()
    device.wait_temperature(1.0)
    assert clock.now_s() == before_s
    device.set_temperature(90.0)
    device.wait_temperature(1200.0)
    assert device.temperature_c() == pytest.approx(90.0, abs=2.5)
    clock.sleep(600.0)
    assert device.temperature_c() == pytest.approx(90.0, abs=2.5)


@given(
    target_c=st.floats(30, 400),
    rate_c_s=st.floats(0.1, 20),
    lag_s=st.floats(0.5, 10),
    spread=st.floats(4.0, 10),
)
@settings(max_examples=30, deadline=None)
def test_a_regulator_that_is_slow_enough_never_passes_its_target(target_c, rate_c_s, lag_s, spread) -> None:
    heater = VirtualHeater(rate_c_s=rate_c_s, lag_s=lag_s, tau_s=spread * lag_s)
    heater.regulate(target_c, 0.0)
    for k in range(200):
        # the step of the integration shows as a small part of one step's warming
        assert heater.measured_c(5.0 * k) <= target_c + 0.02 * rate_c_s


def hold(device: HeatedDevice, clock: VirtualClock, duration_s: float) -> None:
    for _ in range(round(duration_s)):
        clock.sleep(1.0)
        device.temperature_c()


FAULTS = {
    "broken_at_s": "rose from",
    "sensor_loose_at_s": "rose from",
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_heater_that_does_not_become_warmer_is_turned_off(fault: str) -> None:
    heater = VirtualHeater()
    device, clock = plate(heater)
    device.set_temperature(150.0)
    setattr(heater, fault, 30.0)
    with pytest.raises(RigError, match=f"{FAULTS[fault]}.*mains"):
        device.wait_temperature(3600.0)
    assert clock.now_s() < 30 + 130  # some rise was seen yet, then a whole window without
    assert heater.target_c is None
    with pytest.raises(RigError, match="is off"):
        device.wait_temperature(10.0)


@pytest.mark.parametrize("fault", ["broken_at_s", "sensor_loose_at_s"])
def test_a_heater_that_loses_its_temperature_is_turned_off(fault: str) -> None:
    heater = VirtualHeater()
    device, clock = plate(heater)
    device.set_temperature(150.0)
    device.wait_temperature(600.0)
    setattr(heater, fault, clock.now_s() + 100.0)
    with pytest.raises(RigError, match=r"fell to .* after it had reached 150 C"):
        hold(device, clock, 600)
    assert heater.target_c is None


def test_a_welded_relay_is_told_in_time() -> None:
    heater = VirtualHeater()
    device, clock = plate(heater)
    device.set_temperature(120.0)
    heater.stuck_at_s = 50.0
    with pytest.raises(RigError, match=r"where 120 C were set.*at the mains"):
        hold(device, clock, 600)
    assert heater.hottest_c < 145


def test_a_weak_heater_misses_its_deadline_and_is_turned_off() -> None:
    heater = VirtualHeater(rate_c_s=0.2)
    device, _ = plate(heater)
    device.set_temperature(150.0)
    with pytest.raises(RigError, match=r"not 150 C after 300 s"):
        device.wait_temperature(300.0)
    assert heater.target_c is None


@pytest.mark.parametrize("temperature_c", [-5.0, 0.0, 201.0, float("nan")])
def test_temperatures_out_of_bounds_are_refused(temperature_c: float) -> None:
    heater = VirtualHeater()
    with pytest.raises(InputError, match="allowed is above 0 to 200"):
        plate(heater)[0].set_temperature(temperature_c)
    assert heater.target_c is None


def test_a_relay_that_is_welded_from_the_start_is_told_although_the_plate_is_above_its_target() -> None:
    """It may cool down to the target, but nothing may heat it further."""
    heater = VirtualHeater()
    device, clock = plate(heater)
    device.set_temperature(153.0)
    device.wait_temperature(600.0)
    heater.stuck_at_s = clock.now_s()
    device.set_temperature(150.0)
    with pytest.raises(RigError, match=r"where 150 C were set.*at the mains"):
        hold(device, clock, 600)
    assert heater.hottest_c < 180
