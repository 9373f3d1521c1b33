"""The load by a pump: what goes over the wire, and what the chamber gets."""

import pytest

from planner.errors import InputError, RigError
from rig.devices import PostLoad
from rig.dialects.new_era import Alarm, Dispensed
from rig.pump_load import AuditedLoad, PumpLoad, PumpSetup
from rig.transport import Clock, SimulatedTransport, Transport, VirtualClock
from rig.virtual.new_era import VirtualPump

PAPER = PumpSetup(syringe_diameter_mm=15.9, rate_ml_min=10.0, ml_per_g=1.0, load_g_max=6.5)
BASIC = PumpSetup(syringe_diameter_mm=15.9, rate_ml_min=10.0, ml_per_g=1.0, load_g_max=6.5, watchdog_s=0)


class Overheard:
    """Line whose words to the device are kept."""

    def __init__(self, line: Transport) -> None:
        self._line = line
        self.said: list[bytes] = []

    @property
    def clock(self) -> Clock:
        return self._line.clock

    def write(self, data: bytes) -> None:
        self.said.append(data)
        self._line.write(data)

    def read(self, timeout_s: float) -> bytes:
        return self._line.read(timeout_s)

    def close(self) -> None:
        self._line.close()


def rig(pump: VirtualPump, setup: PumpSetup = PAPER) -> tuple[PumpLoad, Overheard]:
    line = Overheard(SimulatedTransport(pump, VirtualClock()))
    return PumpLoad(line, setup), line


def change(load: PumpLoad, load_g: float) -> None:
    load.set_load(load_g)
    load.wait_settled(120.0)


def test_it_is_a_post_load() -> None:
    assert isinstance(rig(VirtualPump())[0], PostLoad)


def test_nothing_is_said_before_the_first_verb() -> None:
    assert rig(VirtualPump())[1].said == []


@pytest.mark.parametrize("setup", [PAPER, BASIC])
@pytest.mark.parametrize("ml_per_g", [1.0, 0.7])
def test_the_chamber_gets_each_load(setup: PumpSetup, ml_per_g: float) -> None:
    pump = VirtualPump()
    load, _ = rig(pump, PumpSetup(**{**vars(setup), "ml_per_g": ml_per_g}))
    loads = [1.5, 6.5, 0.25, 0.25, 6.0, 1.0, 6.0, 2.003, 0.0]
    for load_g in loads:
        change(load, load_g)
        assert load.load_g() == pytest.approx(load_g, abs=0.001)
        assert pump.plunger.moved_ml == pytest.approx(load_g * ml_per_g, abs=0.001)
        assert pump.plunger.water_ml == pytest.approx(load_g * ml_per_g, abs=0.02)
    assert pump.plunger.runs == len(loads) - 1  # the load that was there already needed none
    assert pump.log.count("RUN") == len(loads) - 1


def test_the_doses_do_not_depend_on_how_often_the_counters_were_asked() -> None:
    def said(polls: int) -> list[bytes]:
        load, line = rig(VirtualPump(diameter_mm=15.9))
        for step in range(300):
            load.set_load(step * 3701 % 13001 / 2000)  # half of the doses end in half a microlitre
            for _ in range(polls):
                load.keep_alive()
            load.wait_settled(120.0)
        return [data for data in line.said if b"VOL" in data]

    assert said(0) == said(3) != []


def test_small_syringes_are_told_microlitres() -> None:
    pump = VirtualPump(diameter_mm=15.9)
    setup = PumpSetup(syringe_diameter_mm=12.0, rate_ml_min=5.0, ml_per_g=1.0, load_g_max=6.5)
    load, _ = rig(pump, setup)
    change(load, 0.5)
    change(load, 3.0)
    assert "VOL500.0" in pump.log
    assert "VOL2500" in pump.log
    assert pump.plunger.moved_ml == pytest.approx(3.0, abs=0.001)


def test_golden_bytes_of_two_doses() -> None:
    pump = VirtualPump(diameter_mm=15.9)
    pump.alarm = None
    load, line = rig(pump, BASIC)
    load.connect()
    assert load.identity == "NE1000V3.923"
    assert line.said[0] == bytes.fromhex("0d 02 09 30 53 41 46 30 59 ad 03 0d")
    line.said.clear()
    change(load, 1.5)
    change(load, 0.25)
    text = b"".join(line.said).decode()
    audit, polls = "0DIS 0DIS ", "0DIS 0DIS " * 19
    words = text.replace("\r", " ")
    assert words.startswith(
        "0VER " + audit + "0DIA 0RAT 0DIR 0VOL 0VOL1.500 0VOL " + audit + "0RUN " + polls + "0VER " + audit
    )
    assert "0DIA 0RAT 0DIR 0DIR 0DIRWDR 0DIR 0VOL 0VOL1.250 0VOL " + audit + "0RUN " in words
    assert words.count("RUN") == 2


def test_a_program_left_in_the_pump_does_not_run_on() -> None:
    pump = VirtualPump(diameter_mm=15.9)
    pump.plunger.phases[2] = type(pump.plunger.phases[1])(function="RAT", volume=2.0)
    pump.resumes_after_power_failure = True
    load, _ = rig(pump)
    change(load, 1.0)
    assert pump.plunger.moved_ml == pytest.approx(1.0, abs=0.001)
    assert not pump.resumes_after_power_failure


def test_stop_leaves_the_load_as_it_is_and_the_next_dose_is_the_rest() -> None:
    pump = VirtualPump()
    load, line = rig(pump)
    load.set_load(3.0)
    line.clock.sleep(6.0)
    load.stop()
    stopped_ml = pump.plunger.moved_ml
    assert 0.9 < stopped_ml < 1.2
    line.clock.sleep(20.0)
    assert load.load_g() == pytest.approx(stopped_ml, abs=0.001)
    load.wait_settled(1.0)  # nothing to wait for
    change(load, 3.0)
    assert pump.plunger.moved_ml == pytest.approx(3.0, abs=0.001)


def test_the_same_load_again_leaves_the_dose_alone() -> None:
    pump = VirtualPump()
    load, _ = rig(pump)
    load.set_load(3.0)
    change(load, 3.0)
    assert pump.plunger.runs == 1


def test_a_new_load_replaces_one_that_is_being_pumped() -> None:
    pump = VirtualPump()
    load, line = rig(pump)
    load.set_load(6.0)
    line.clock.sleep(6.0)
    change(load, 0.5)
    assert pump.plunger.moved_ml == pytest.approx(0.5, abs=0.001)


def test_stop_needs_no_dose_and_no_connection() -> None:
    pump = VirtualPump()
    pump.alarm = None
    pump.plunger.run()
    pump.plunger.phases[1].rate = 5.0
    load, _ = rig(pump)
    load.stop()
    assert not pump.plunger.running
    with pytest.raises(RigError, match="in the middle of a dose when it was connected"):
        load.load_g()
    load.prime(0.0)
    assert load.load_g() == 0.0


def test_a_deadline_is_kept() -> None:
    load, line = rig(VirtualPump())
    load.set_load(6.0)
    started_s = line.clock.now_s()
    with pytest.raises(RigError, match=r"mL of 6\.000 mL were moved in 10 s"):
        load.wait_settled(10.0)
    assert line.clock.now_s() - started_s < 11.5


@pytest.mark.parametrize("load_g", [-0.1, 6.6, float("nan")])
def test_loads_out_of_range_are_refused_before_anything_is_said(load_g: float) -> None:
    load, line = rig(VirtualPump())
    with pytest.raises(InputError, match=r"allowed is 0 to 6\.5"):
        load.set_load(load_g)
    assert line.said == []


def test_keeping_alive_feeds_the_watchdog() -> None:
    pump = VirtualPump()
    setup = PumpSetup(syringe_diameter_mm=15.9, rate_ml_min=1.0, ml_per_g=1.0, load_g_max=6.5, watchdog_s=10)
    load, line = rig(pump, setup)
    load.set_load(1.0)
    for _ in range(10):
        line.clock.sleep(8.0)
        load.keep_alive()
    load.wait_settled(1.0)
    assert pump.plunger.moved_ml == pytest.approx(1.0, abs=0.001)
    load.set_load(2.0)
    line.clock.sleep(30.0)
    with pytest.raises(RigError, match="heard nothing for too long"):
        load.wait_settled(60.0)
    change(load, 2.0)
    assert pump.plunger.moved_ml == pytest.approx(2.0, abs=0.001)


def test_the_watchdog_between_doses_is_harmless() -> None:
    pump = VirtualPump()
    load, line = rig(pump)
    change(load, 1.0)
    line.clock.sleep(600.0)
    pump.next_event_s(line.clock.now_s())
    assert pump.alarm is Alarm.TIME_OUT
    change(load, 2.0)
    assert pump.plunger.moved_ml == pytest.approx(2.0, abs=0.001)


@pytest.mark.parametrize("killed_after_s", [0.0, 3.0, 40.0])
def test_a_run_cut_off_in_a_dose_is_taken_up_by_its_counters(killed_after_s: float) -> None:
    pump = VirtualPump()
    line = SimulatedTransport(pump, VirtualClock())
    first = PumpLoad(line, PAPER)
    change(first, 1.0)
    first.load_g()
    known = first.audited
    assert known is not None
    first.set_load(5.0)
    line.clock.sleep(killed_after_s)
    again = PumpLoad(line, PAPER, start=known)
    again.connect()
    assert again.load_g() == pytest.approx(pump.plunger.moved_ml, abs=0.001)
    change(again, 5.0)
    assert pump.plunger.moved_ml == pytest.approx(5.0, abs=0.001)


def test_counters_that_cannot_belong_to_the_run_are_refused() -> None:
    known = AuditedLoad(load_g=3.0, counters=Dispensed(infused_ml=3.0, withdrawn_ml=0.0, resolution_ml=0.001))
    for alarm in (None, Alarm.RESET):
        pump = VirtualPump()
        pump.alarm = alarm
        load = PumpLoad(SimulatedTransport(pump, VirtualClock()), PAPER, start=known)
        with pytest.raises(RigError, match="the load is not known"):
            load.connect()
        load.prime(2.0)
        change(load, 2.5)
        assert pump.plunger.moved_ml == pytest.approx(0.5, abs=0.001)


def test_a_dose_that_creeps_is_not_waited_for() -> None:
    """As after the rate was lowered on the pump's keys."""
    pump = VirtualPump()
    load, line = rig(pump)
    load.set_load(2.0)
    for phase in pump.plunger.phases.values():
        phase.rate *= 1e-3
    with pytest.raises(RigError, match="check the rate"):
        load.wait_settled(86_400.0)
    assert line.clock.now_s() < 120.0
