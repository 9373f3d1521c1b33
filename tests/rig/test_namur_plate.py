"""The hot plate on a line: golden bytes, readings, its watchdog, and what goes wrong."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.errors import InputError, RigError
from rig.devices import HotPlate
from rig.dialects.lines import LONGEST, LineParser
from rig.dialects.namur import encode, value
from rig.heated_device import HeatedDevice
from rig.heating_watch import HeatingLimits
from rig.namur_plate import NamurThermostat
from rig.transport import Fault, FaultyTransport, SimulatedTransport, VirtualClock
from rig.virtual.heater import VirtualHeater
from rig.virtual.namur import VirtualNamurPlate


def rig(plate: VirtualNamurPlate, *faults: Fault) -> tuple[HeatedDevice, VirtualClock, NamurThermostat]:
    clock = VirtualClock()
    thermostat = NamurThermostat(FaultyTransport(SimulatedTransport(plate, clock), faults), watchdog_s=60)
    device = HeatedDevice(thermostat, clock, name="hot plate", temperature_c_max=200.0, limits=HeatingLimits())
    return device, clock, thermostat


def test_commands_on_the_wire() -> None:
    assert encode("OUT_SP_1 150") == b"OUT_SP_1 150 \r\n"
    assert encode("OUT_WD1@60") == b"OUT_WD1@60 \r\n"


@pytest.mark.parametrize("command", ["out_sp_1 150", "OUT_SP_1 150\r\nSTART_1", "OUT_SP_1  1e3", "", "STOP_1 \xb0"])
def test_what_is_no_command_is_refused(command: str) -> None:
    with pytest.raises(InputError, match="cannot be sent"):
        encode(command)


@pytest.mark.parametrize(
    ("reply", "command", "number"),
    [
        ("25.3 2", "IN_PV_2", 25.3),
        ("25.3", "IN_PV_2", 25.3),
        ("150 1", "IN_SP_1", 150.0),
        ("25.3 1", "IN_PV_2", None),
        ("60", "OUT_WD1@60", 60.0),
        ("C-MAG HS7", "IN_PV_2", None),
        ("2\xb2.3 2", "IN_PV_2", None),
        ("25.3 2 2", "IN_PV_2", None),
    ],
)
def test_numbers_belong_to_their_channel(reply: str, command: str, number: float | None) -> None:
    assert value(reply, command) == number


def test_it_heats_holds_and_is_off_in_the_end() -> None:
    plate = VirtualNamurPlate()
    device, clock, thermostat = rig(plate)
    assert isinstance(device, HotPlate)
    assert plate.log == []  # no word before the first verb
    device.set_temperature(150.0)
    assert thermostat.identity == "C-MAG HS7"
    assert plate.log == [
        *("IN_NAME", "IN_PV_2", "IN_PV_2", "IN_SP_1", "OUT_SP_1 150", "IN_SP_1"),
        *("OUT_WD1@60", "START_1", "IN_SP_1", "START_1"),
    ]
    device.wait_temperature(600.0)
    for _ in range(100):
        clock.sleep(10.0)
        assert device.temperature_c() == pytest.approx(150.0, abs=2.5)
    assert not plate.error_2
    assert plate.log.count("OUT_WD1@60") > 50
    device.turn_off()
    assert not plate.heats


def test_a_host_that_is_gone_ends_the_heating() -> None:
    plate = VirtualNamurPlate()
    device, clock, _ = rig(plate)
    device.set_temperature(150.0)
    device.wait_temperature(600.0)
    clock.sleep(300.0)
    with pytest.raises(RigError, match="was not read for"):
        device.temperature_c()
    assert plate.error_2
    assert not plate.heats


def test_a_model_that_forgets_its_target_is_told_it_again() -> None:
    plate = VirtualNamurPlate()
    plate.forgets_target_at_start = True
    device, _, _ = rig(plate)
    device.set_temperature(150.0)
    device.wait_temperature(600.0)
    assert plate.heats


def test_a_safety_temperature_that_is_too_low_is_told() -> None:
    device, _, _ = rig(VirtualNamurPlate(safety_c=100.0))
    with pytest.raises(RigError, match=r"stays 100 C where 150 C were set; raise its safety temperature"):
        device.set_temperature(150.0)


def test_a_plate_that_falls_silent_is_told() -> None:
    plate = VirtualNamurPlate()
    device, clock, _ = rig(plate)
    device.set_temperature(150.0)
    plate.deaf = True
    with pytest.raises(RigError, match="does not answer to IN_PV_2"):
        device.wait_temperature(600.0)
    clock.sleep(120.0)
    plate.next_event_s(clock.now_s())
    assert not plate.heats  # by its own watchdog
    with pytest.raises(RigError, match="no NAMUR hot plate answers"):
        rig(plate)[0].temperature_c()


def test_a_dead_element_behind_the_wire_is_noticed() -> None:
    plate = VirtualNamurPlate(VirtualHeater(rate_c_s=0.0))
    device, _, _ = rig(plate)
    device.set_temperature(150.0)
    with pytest.raises(RigError, match="rose from"):
        device.wait_temperature(3600.0)
    assert not plate.heats


@pytest.mark.parametrize("way", ["out", "in"])
@pytest.mark.parametrize("kind", ["drop", "duplicate", "delay", "merge"])
def test_faults_on_the_line_end_at_the_temperature_or_with_the_heating_off(kind, way) -> None:
    for at in range(1, 160, 3):
        plate = VirtualNamurPlate()
        device, clock, _ = rig(plate, Fault(kind=kind, way=way, at=at, delay_s=2.0))
        try:
            device.set_temperature(150.0)
            device.wait_temperature(600.0)
        except RigError:
            clock.sleep(61.0)
            plate.next_event_s(clock.now_s())
            assert not plate.heats
        else:
            assert plate.heater.body_c(clock.now_s()) == pytest.approx(150.0, abs=3.0)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.one_of(st.binary(max_size=120), st.sampled_from([b"25.3 2 \r\n", b"\r", b"\n"]))))
def test_any_bytes_are_survived(pieces: list[bytes]) -> None:
    parser = LineParser()
    for piece in pieces:
        for line in parser.feed(piece):
            assert 0 < len(line) <= LONGEST
            value(line, "IN_PV_2")
        assert len(parser._line) <= LONGEST + 1
    parser.forget()
    assert parser.feed(b"25.3 2 \r\n") == ["25.3 2"]


@pytest.mark.parametrize("count", [500, pytest.param(10_000, marks=pytest.mark.slow)])
def test_noise_in_bulk_is_survived(count: int) -> None:
    source, parser = random.Random(5), LineParser()
    for _ in range(count):  # a thousand bytes each
        for line in parser.feed(source.randbytes(600) + bytes(source.choices(b"0123456789. -\r\n", k=400))):
            value(line, "IN_PV_2")
        assert len(parser._line) <= LONGEST + 1
