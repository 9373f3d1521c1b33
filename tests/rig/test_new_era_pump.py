"""The virtual NE-1000 against what its manual says, and against closed form."""

from math import exp, inf

import pytest

from rig.dialects.new_era import packet
from rig.virtual.device import VirtualDevice
from rig.virtual.new_era import ANSWER_S, BOOT_S, VirtualPump


class Bench:
    """Says commands to a pump one after the other and returns what it answers."""

    def __init__(self, pump: VirtualPump) -> None:
        self.pump = pump
        self.now_s = 0.0

    def say(self, *commands: str, safe: bool = False) -> bytes:
        for command in commands:
            data = command.encode()
            self.pump.receive(packet(data) if safe else data + b"\r", self.now_s)
            self.now_s += ANSWER_S
        return self.pump.send(self.now_s)

    def wait(self, duration_s: float) -> bytes:
        self.now_s += duration_s
        return self.pump.send(self.now_s)


@pytest.fixture
def bench() -> Bench:
    bench = Bench(VirtualPump(diameter_mm=15.9, lag_s=0.5))
    bench.say("VER")
    return bench


def test_it_is_a_device() -> None:
    pump: VirtualDevice = VirtualPump()
    assert pump.next_event_s(0.0) == inf


def test_the_first_reply_after_power_is_the_alarm_and_its_command_is_not_executed() -> None:
    bench = Bench(VirtualPump())
    assert bench.say("DIRWDR") == b"\x0200A?R\x03"
    assert bench.say("DIR") == b"\x0200SINF\x03"


@pytest.mark.parametrize(
    ("command", "answer"),
    [
        ("VER", "NE1000V3.923"),
        ("dia 12.5", ""),
        ("XYZ", "?"),
        ("VOL123.45", "?OOR"),
        ("VOL0.1234", "?OOR"),
        ("DIA99", "?OOR"),
        ("RAT11MM", "?OOR"),
        ("RAT10MM", ""),
        ("CLD", "?"),
        ("SAF300", "?OOR"),
    ],
)
def test_answers(bench: Bench, command: str, answer: str) -> None:
    assert bench.say(command) == f"\x0200S{answer}\x03".encode()


def test_units_flip_at_14_mm(bench: Bench) -> None:
    assert b"0.000UL" in bench.say("DIA14.00", "VOL")
    assert b"0.000ML" in bench.say("DIA14.01", "VOL")


def test_another_address_is_not_answered(bench: Bench) -> None:
    assert bench.say("3VER") == b""


def test_a_dose_takes_its_time_and_the_water_follows(bench: Bench) -> None:
    bench.say("VOL0.500", "RAT6.000MM", "RUN")
    start_s = bench.now_s - ANSWER_S
    plunger = bench.pump.plunger
    assert bench.pump.next_event_s(bench.now_s) == pytest.approx(start_s + 5.0, abs=1e-3)
    bench.now_s = start_s + 2.0
    assert bench.say("DIS") == b"\x0200II0.200W0.000ML\x03"
    elapsed_s = bench.now_s - start_s
    behind_ml = 0.1 * 0.5 * (1 - exp(-elapsed_s / 0.5))
    assert plunger.moved_ml == pytest.approx(0.1 * elapsed_s)
    assert plunger.water_ml == pytest.approx(0.1 * elapsed_s - behind_ml)
    assert bench.say("VOL1") == b"\x0200I?NA\x03"
    bench.wait(20.0)
    assert bench.say("DIS") == b"\x0200SI0.500W0.000ML\x03"
    assert plunger.moved_ml == pytest.approx(0.5, abs=plunger.step_ml)
    assert plunger.water_ml == pytest.approx(plunger.moved_ml)


def test_stop_pauses_run_goes_on_and_stop_twice_ends(bench: Bench) -> None:
    bench.say("VOL0.500", "RAT6.000MM", "RUN")
    bench.wait(1.0)
    assert bench.say("STP") == b"\x0200P\x03"
    bench.say("RUN")
    bench.wait(20.0)
    assert bench.pump.plunger.moved_ml == pytest.approx(0.5, abs=1e-4)
    bench.say("RUN")
    bench.wait(1.0)
    assert bench.say("STP", "STP")[-2:] == b"S\x03"
    assert bench.wait(20.0) == b""


def test_a_program_goes_on_into_its_second_phase(bench: Bench) -> None:
    bench.say("RAT6.000MM", "VOL0.100", "PHN2", "FUNRAT", "RAT6.000MM", "VOL0.200", "RUN")
    bench.wait(60.0)
    assert bench.pump.plunger.moved_ml == pytest.approx(0.3, abs=1e-4)


def test_the_watchdog_stops_it_and_says_so(bench: Bench) -> None:
    bench.say("RAT6.000MM", "VOL1.000")
    assert bench.say("SAF5") == packet(b"00S")
    bench.say("0RUN", safe=True)
    assert bench.wait(60.0) == packet(b"00A?T")
    assert bench.pump.plunger.moved_ml == pytest.approx(0.5, abs=1e-3)
    assert bench.say("DIS", safe=True) == packet(b"00A?T")  # telling by itself did not acknowledge it
    assert bench.say("SAF0", safe=True) == b"\x0200S\x03"


def test_safe_mode_hears_only_whole_packets(bench: Bench) -> None:
    bench.say("SAF9")
    assert bench.say("DIS") == b""
    bench.pump.receive(packet(b"0VER")[:-1] + b"\x04", bench.now_s)
    assert bench.wait(0.1) == packet(b"00S?COM")
    bench.pump.receive(packet(b"0VER")[:-3], bench.now_s)
    bench.wait(0.6)
    assert bench.say("DIS", safe=True) == packet(b"00SI0.000W0.000ML")


def test_a_brown_out_keeps_settings_and_loses_counters(bench: Bench) -> None:
    bench.say("RAT6.000MM", "VOL1.000", "RUN")
    bench.pump.brown_out_at_ml = 0.25
    bench.wait(30.0)
    assert bench.pump.plunger.moved_ml == pytest.approx(0.25)
    assert bench.say("DIS") == b"\x0200A?R\x03"
    assert bench.say("DIS") == b"\x0200SI0.000W0.000ML\x03"
    assert bench.say("VOL") == b"\x0200S1.000ML\x03"
    bench.pump.brown_out(bench.now_s)
    assert bench.say("VER") == b""
    bench.wait(BOOT_S)
    assert bench.say("VER") == b"\x0200A?R\x03"
