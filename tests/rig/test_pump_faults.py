"""No fault of pump or line may double a dose, lose one, or make the told load differ from the true one in silence."""

from collections.abc import Iterator
from contextlib import nullcontext, suppress
from dataclasses import replace
from itertools import cycle, islice
from math import inf

import pytest

from planner.errors import RigError
from rig.pump_load import PumpLoad, PumpSetup
from rig.transport import Fault, FaultyTransport, SimulatedTransport, VirtualClock
from rig.virtual.new_era import VirtualPump

MODES = {"safe": 30, "basic": 0}
LOADS_G = (0.3, 0.1)
CLOSE_ML = 0.006
"""The driver's tolerance of a dose, and a step of the counters."""


def setup(mode: str) -> PumpSetup:
    return PumpSetup(
        syringe_diameter_mm=15.9, rate_ml_min=10.0, ml_per_g=1.0, load_g_max=6.5, watchdog_s=MODES[mode], settle_s=0.2
    )


def rig(mode: str, *faults: Fault) -> tuple[PumpLoad, VirtualPump, FaultyTransport]:
    pump = VirtualPump(diameter_mm=15.9, lag_s=0.1)
    line = FaultyTransport(SimulatedTransport(pump, VirtualClock()), faults)
    return PumpLoad(line, setup(mode)), pump, line


def change(load: PumpLoad, load_g: float) -> None:
    load.set_load(load_g)
    load.wait_settled(60.0)


@pytest.mark.parametrize("mode", MODES)
def test_a_stall_is_told_with_the_volume_and_the_rest_is_pumped_next(mode: str) -> None:
    load, pump, _ = rig(mode)
    change(load, 1.0)
    pump.stall_at_ml = 1.7
    load.set_load(3.0)
    with pytest.raises(RigError, match=r"0\.7\d\d mL of 2\.000 mL were moved: the pump stalled"):
        load.wait_settled(60.0)
    assert load.load_g() == pytest.approx(1.7, abs=0.001)
    change(load, 3.0)
    assert pump.plunger.moved_ml == pytest.approx(3.0, abs=0.001)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("reply", ["RUN", "VOL", "DIR", "DIS", "STP", "VER", "CLD", "SAF"])
def test_a_lost_reply_neither_doubles_nor_skips_a_dose(mode: str, reply: str) -> None:
    load, pump, _ = rig(mode)
    for step, load_g in enumerate((6.0, 1.0, 5.0, 0.5)):
        pump.lose_reply_to = reply
        change(load, load_g)
        assert pump.plunger.moved_ml == pytest.approx(load_g, abs=0.001)
        assert pump.plunger.runs == step + 1


@pytest.mark.parametrize("mode", MODES)
def test_a_lost_reply_to_the_shortest_dose(mode: str) -> None:
    # It is over before anyone can ask, so that only the counters tell that it happened.
    load, pump, _ = rig(mode)
    change(load, 1.0)
    pump.lose_reply_to = "RUN"
    change(load, 1.001)
    assert pump.plunger.runs == 2
    assert load.load_g() == pytest.approx(1.001, abs=1e-6)


@pytest.mark.parametrize("mode", MODES)
def test_a_brown_out_during_a_dose_makes_the_load_unknown_until_it_is_primed(mode: str) -> None:
    load, pump, _ = rig(mode)
    change(load, 1.0)
    pump.brown_out_at_ml = 1.8
    load.set_load(3.0)
    with pytest.raises(RigError, match=r"lost its power.*\(the chamber holds between 1\.\d+ and 3\.000 mL\).*prime"):
        load.wait_settled(60.0)
    for verb in (load.load_g, lambda: load.set_load(3.0), lambda: load.wait_settled(1.0)):
        with pytest.raises(RigError, match="the load is not known"):
            verb()
    load.stop()
    assert pump.plunger.moved_ml == pytest.approx(1.8)
    load.prime(1.8)
    change(load, 3.0)
    assert pump.plunger.moved_ml == pytest.approx(3.0, abs=0.001)


@pytest.mark.parametrize("mode", MODES)
def test_a_run_killed_in_its_first_dose_before_a_brown_out_is_not_taken_up(mode: str) -> None:
    # The counters are zero before and after, so that only the alarm tells.
    load, pump, line = rig(mode)
    load.connect()
    known = load.audited
    load.set_load(3.0)
    line.clock.sleep(5.0)
    pump.brown_out(line.clock.now_s())
    line.clock.sleep(5.0)
    assert known is not None
    assert known.counters.net_ml == 0
    again = PumpLoad(line, setup(mode), start=known)
    with pytest.raises(RigError, match="lost its power"):
        again.load_g()


@pytest.mark.parametrize("mode", MODES)
def test_a_brown_out_between_doses_is_harmless(mode: str) -> None:
    load, pump, line = rig(mode)
    change(load, 2.0)
    pump.brown_out(line.clock.now_s())
    line.clock.sleep(5.0)
    change(load, 3.0)
    assert load.load_g() == pytest.approx(3.0, abs=0.001)
    assert pump.plunger.moved_ml == pytest.approx(3.0, abs=0.001)


@pytest.mark.parametrize("mode", MODES)
def test_another_syringe_diameter_set_on_the_keys_is_noticed(mode: str) -> None:
    load, pump, _ = rig(mode)
    change(load, 2.0)
    pump.plunger.set_diameter(12.0)
    with pytest.raises(RigError, match="counters went back"):
        load.set_load(3.0)
    assert pump.plunger.runs == 1


@pytest.mark.parametrize("mode", MODES)
def test_other_units_set_on_the_keys_are_followed(mode: str) -> None:
    load, pump, _ = rig(mode)
    change(load, 2.0)
    pump.plunger.units = "UL"
    change(load, 3.0)
    assert pump.plunger.moved_ml == pytest.approx(3.0, abs=0.001)


@pytest.mark.parametrize("mode", MODES)
def test_water_moved_on_the_keys_is_counted(mode: str) -> None:
    load, pump, line = rig(mode)
    change(load, 2.0)
    pump.plunger.run()
    line.clock.sleep(30.0)
    change(load, 2.5)
    assert pump.plunger.moved_ml == pytest.approx(2.5, abs=0.001)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize(
    ("rate_ml_min", "address", "sentence"),
    [(12.0, 0, "at RAT12.00MM .* out of range"), (10.0, 4, "something answers, but no New Era pump with address 4")],
)
def test_wrong_rate_or_address(mode: str, rate_ml_min: float, address: int, sentence: str) -> None:
    pump = VirtualPump()
    wrong = PumpSetup(
        syringe_diameter_mm=15.9,
        rate_ml_min=rate_ml_min,
        ml_per_g=1.0,
        load_g_max=6.5,
        address=address,
        watchdog_s=MODES[mode],
    )
    load = PumpLoad(SimulatedTransport(pump, VirtualClock()), wrong)
    with pytest.raises(RigError, match=sentence):
        load.set_load(1.0)
    assert pump.plunger.runs == 0


class Grbl:
    """Something else on the port."""

    def __init__(self) -> None:
        self._outbox = b""

    def receive(self, data: bytes, now_s: float) -> None:
        self._outbox += b"error:2\r\n" * data.count(b"\r")

    def send(self, now_s: float) -> bytes:
        data, self._outbox = self._outbox, b""
        return data

    def next_event_s(self, now_s: float) -> float:
        return float("inf")


def test_another_device_on_the_port() -> None:
    load = PumpLoad(SimulatedTransport(Grbl(), VirtualClock()), setup("basic"))
    with pytest.raises(RigError, match="something answers, but no New Era pump"):
        load.connect()


class Nobody(Grbl):
    """Nothing on the port."""

    def receive(self, data: bytes, now_s: float) -> None:
        pass


def test_nothing_on_the_port() -> None:
    load = PumpLoad(SimulatedTransport(Nobody(), VirtualClock()), setup("safe"))
    with pytest.raises(RigError, match="nothing answers; check power"):
        load.connect()


KINDS = (
    *(Fault(kind="flip", way="out", at=0, bit=bit) for bit in range(8)),
    *(Fault(kind="delay", way="out", at=0, delay_s=delay_s) for delay_s in (0.3, 0.8, 3.0)),
    *(Fault(kind="insert", way="out", at=0, inserted=inserted) for inserted in (b"\x02", b"\x03", b"0", b"\r")),
    Fault(kind="drop", way="out", at=0),
    Fault(kind="duplicate", way="out", at=0),
    Fault(kind="unplug", way="out", at=0),
)


def faults(step: int, kinds_each: int) -> Iterator[tuple[str, Fault]]:
    """So many kinds of fault, in turn, on every so-many-th byte of a run, in both modes and both ways."""
    kinds = cycle(KINDS)
    for mode in MODES:
        for at in range(0, 700, step):
            yield from ((mode, replace(kind, way="out", at=at)) for kind in islice(kinds, kinds_each))
        for at in range(0, 1300, step):
            yield from ((mode, replace(kind, way="in", at=at)) for kind in islice(kinds, kinds_each))


def check_doses(mode: str, fault: Fault, brown_out_at_ml: float = inf) -> bool:
    """Run two loads over a faulty line, and perhaps a brown-out; return whether the run went through."""
    load, pump, line = rig(mode, fault)
    pump.brown_out_at_ml = brown_out_at_ml
    went_through = True
    try:
        for load_g in LOADS_G:
            change(load, load_g)
    except RigError:
        went_through = False
    else:
        assert pump.plunger.moved_ml == pytest.approx(LOADS_G[-1], abs=CLOSE_ML), fault
        assert pump.plunger.runs == len(LOADS_G), fault
    # Whoever takes it up on a new line learns the true load and pumps the rest, or learns that it is not known.
    clock = VirtualClock()
    clock.advance_to(line.clock.now_s() + 60.0)
    if (known := load.audited) is not None:
        again = PumpLoad(SimulatedTransport(pump, clock), setup(mode), start=known)
        with nullcontext() if brown_out_at_ml == inf else suppress(RigError):
            change(again, 0.2)
            assert pump.plunger.moved_ml == pytest.approx(0.2, abs=CLOSE_ML), fault
    return went_through


@pytest.mark.parametrize("brown_out_at_ml", [0.001, 0.15, 0.4])
def test_faults_on_bytes_of_the_line_around_a_brown_out(brown_out_at_ml: float) -> None:
    for mode, fault in faults(31, 1):
        assert not check_doses(mode, fault, brown_out_at_ml)


def test_faults_on_bytes_of_the_line() -> None:
    outcomes = [(fault.kind, check_doses(mode, fault)) for mode, fault in faults(11, 1)]
    assert len(outcomes) > 300
    assert all(went_through for kind, went_through in outcomes if kind != "unplug")


@pytest.mark.slow
def test_every_fault_on_every_fifth_byte_of_the_line() -> None:
    outcomes = [(fault.kind, check_doses(mode, fault)) for mode, fault in faults(5, len(KINDS))]
    failed = sum(not went_through for kind, went_through in outcomes if kind != "unplug")
    assert failed < 1e-3 * len(outcomes)
