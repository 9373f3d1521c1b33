"""The lamp, the extruder and the enclosure, on a virtual clock."""

from math import exp

import pytest

from planner.errors import InputError, RigError
from rig.devices import Enclosure, Extruder, UvLamp, WarmsUp
from rig.extruder import PneumaticExtruder
from rig.lamp import SwitchedLamp
from rig.transport import VirtualClock
from rig.virtual.enclosure import VirtualEnclosure
from rig.virtual.extruder import VirtualExtruder
from rig.virtual.lamp import VirtualLamp

SQUARE = ((0.0, 0.0), (60.0, 0.0), (60.0, 40.0), (0.0, 40.0))


def lamp(tau_s: float, warm_up_s: float) -> tuple[SwitchedLamp, VirtualLamp, VirtualClock]:
    clock = VirtualClock()
    model = VirtualLamp(clock, tau_s=tau_s)
    return SwitchedLamp(model, clock, warm_up_s=warm_up_s), model, clock


def extruder(flow_ml_min: float = 0.96) -> tuple[PneumaticExtruder, VirtualExtruder, VirtualClock]:
    clock = VirtualClock()
    model = VirtualExtruder(clock, flow_ml_min=flow_ml_min)
    return PneumaticExtruder(model, clock, flow_ml_min=0.96), model, clock


def test_a_lamp_warms_up_once_and_gives_its_dose() -> None:
    device, model, clock = lamp(20.0, 100.0)
    assert isinstance(device, UvLamp)
    assert isinstance(device, WarmsUp)
    device.turn_on()
    clock.sleep(40.0)
    device.turn_on()
    assert model.brightness() == pytest.approx(1 - exp(-2))
    device.wait_warm(100.0)
    assert clock.now_s() == 100.0
    before_s = model.dose_s()
    clock.sleep(180.0)
    device.turn_off()
    assert model.dose_s() - before_s == pytest.approx(180.0, rel=1e-2)
    assert before_s == pytest.approx(100 - 20 * (1 - exp(-5)))
    clock.sleep(50.0)
    device.turn_off()
    assert model.dose_s() - before_s == pytest.approx(180.0, rel=1e-2)
    assert model.brightness() == 0


def test_a_lamp_without_warm_up_is_ready_at_once_and_one_that_is_off_never() -> None:
    device, model, clock = lamp(0.0, 0.0)
    with pytest.raises(RigError, match="turn it on"):
        device.wait_warm(10.0)
    device.turn_on()
    device.wait_warm(0.0)
    assert (clock.now_s(), model.brightness()) == (0.0, 1.0)
    slow, _, _ = lamp(20.0, 100.0)
    slow.turn_on()
    with pytest.raises(RigError, match="needs 100 s more"):
        slow.wait_warm(10.0)


def test_a_layer_takes_its_volume() -> None:
    device, model, clock = extruder()
    assert isinstance(device, Extruder)
    device.deposit(SQUARE, 0.2)  # 60 x 40 x 0.2 mm = 0.48 mL at 0.96 mL/min
    assert model.flows
    clock.sleep(10.0)
    device.wait_deposited(60.0)
    assert clock.now_s() == pytest.approx(30.0)
    assert model.out_ml() == pytest.approx(0.48)
    assert device.deposited_ml == pytest.approx(0.48)
    assert not model.flows
    device.wait_deposited(1.0)  # nothing to wait for
    device.deposit(SQUARE[::-1], 0.2)
    device.wait_deposited(60.0)
    assert model.out_ml() == pytest.approx(0.96)


def test_the_valve_is_closed_whatever_goes_wrong() -> None:
    device, model, clock = extruder()
    device.deposit(SQUARE, 0.2)
    with pytest.raises(RigError, match=r"0\.16 mL of 0\.48 mL were deposited in 10 s"):
        device.wait_deposited(10.0)
    assert not model.flows
    device.deposit(SQUARE, 0.2)
    clock.sleep(40.0)
    with pytest.raises(RigError, match=r"0\.64 mL of 0\.48 mL.*closed late"):
        device.wait_deposited(60.0)
    assert not model.flows
    device.deposit(SQUARE, 0.2)
    with pytest.raises(RigError, match="being deposited"):
        device.deposit(SQUARE, 0.2)
    device.stop()
    device.stop()
    assert not model.flows


@pytest.mark.parametrize(("outline_mm", "thickness_mm"), [(SQUARE, 0.0), (SQUARE[:2], 0.2)])
def test_nothing_to_cover_is_refused(outline_mm, thickness_mm) -> None:
    device, model, _ = extruder()
    with pytest.raises(InputError, match="correct the Program's film"):
        device.deposit(outline_mm, thickness_mm)
    assert not model.flows


def test_an_enclosure_says_what_its_switch_says() -> None:
    enclosure = VirtualEnclosure()
    assert isinstance(enclosure, Enclosure)
    assert enclosure.is_closed()
    enclosure.door_is_closed = False
    assert not enclosure.is_closed()
    enclosure.switch_is_stuck = True
    assert enclosure.is_closed()
