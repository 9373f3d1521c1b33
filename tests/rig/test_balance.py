"""The balance on a line: weights, zeros, and a pan that does not rest."""

import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.errors import RigError
from rig.devices import Balance
from rig.dialects.sics import Outcome, Reply, understand
from rig.sics_balance import AGREE_G, SicsBalance
from rig.transport import Fault, FaultyTransport, SimulatedTransport, VirtualClock
from rig.virtual.balance import VirtualBalance


class Pan:
    def __init__(self) -> None:
        self.weight_g = 0.0

    def __call__(self, now_s: float) -> float:
        return self.weight_g


def rig(*faults: Fault) -> tuple[SicsBalance, VirtualBalance, Pan, VirtualClock]:
    pan, clock = Pan(), VirtualClock()
    model = VirtualBalance(pan, np.random.default_rng(3))
    return SicsBalance(FaultyTransport(SimulatedTransport(model, clock), faults)), model, pan, clock


@pytest.mark.parametrize(
    ("line", "reply"),
    [
        ("S S     100.00 g", Reply(command="S", outcome=Outcome.STABLE, weight_g=100.0)),
        ("S D    -0.0012 kg", Reply(command="S", outcome=Outcome.MOVING, weight_g=-1.2)),
        ("S I", Reply(command="S", outcome=Outcome.NOT_NOW)),
        ("S +", Reply(command="S", outcome=Outcome.OVERLOAD)),
        ("Z A", Reply(command="Z", outcome=Outcome.DONE)),
        ("Z -", Reply(command="Z", outcome=Outcome.UNDERLOAD)),
        ('I4 A "B021002593"', Reply(command="I4", outcome=Outcome.DONE, serial_number="B021002593")),
        ("ES", Reply(command="", outcome=Outcome.ERROR)),
        ("S S 1\xb2.0 g", None),
        ("S S 12.0 lb", None),
        ("S A", None),
        ("TA A 1.0 g", None),
    ],
)
def test_replies(line: str, reply: Reply | None) -> None:
    assert understand(line) == reply


def test_it_weighs_what_lies_on_it_once_that_rests() -> None:
    balance, _, pan, clock = rig()
    assert isinstance(balance, Balance)
    pan.weight_g = 35.25
    balance.zero()
    assert balance.identity == "B021002593"
    assert balance.load_g() == pytest.approx(0.0, abs=0.003)
    for load_g in (1.5, 6.5, 0.25):
        pan.weight_g = 35.25 + load_g
        before_s = clock.now_s()
        assert balance.load_g() == pytest.approx(load_g, abs=0.004)
        assert 1.0 < clock.now_s() - before_s < 10.0


def test_a_pan_that_shakes_or_is_overloaded_is_told() -> None:
    balance, model, pan, _ = rig()
    model.shakes_g = 0.5
    with pytest.raises(RigError, match="does not come to rest"):
        balance.load_g()
    model.shakes_g = 0.0
    pan.weight_g = 500.0
    with pytest.raises(RigError, match="overloaded"):
        balance.load_g()
    pan.weight_g = -50.0
    with pytest.raises(RigError, match="below its range"):
        balance.zero()


def test_nobody_there_is_told() -> None:
    balance, _, _, _ = rig(Fault(kind="unplug", way="out", at=2))
    with pytest.raises(RigError, match="gone"):
        balance.load_g()
    balance, _, _, _ = rig(*(Fault(kind="drop", way="out", at=at) for at in (0, 4, 8)))  # the I of each I4
    with pytest.raises(RigError, match="no MT-SICS balance answers"):
        balance.load_g()


@pytest.mark.parametrize("kind", ["drop", "flip", "duplicate", "delay", "merge"])
@pytest.mark.parametrize("way", ["out", "in"])
def test_faults_on_the_line_never_give_a_weight_that_is_off(kind, way) -> None:
    for at in range(0, 60, 1 if way == "in" else 3):
        balance, _, pan, _ = rig(Fault(kind=kind, way=way, at=at, bit=at % 3, delay_s=3.0))
        pan.weight_g = 6.25
        try:
            found_g = balance.load_g()
        except RigError:
            continue
        assert found_g == pytest.approx(6.25, abs=AGREE_G + 0.002), at


@given(st.text(max_size=60))
def test_any_line_is_survived(line: str) -> None:
    reply = understand(line)
    assert reply is None or reply.command in ("S", "Z", "I4", "")


def test_lines_of_the_grammar_in_bulk() -> None:
    source = random.Random(5)
    words = ["S", "Z", "I4", " ", "D", "A", "+", "-", "12.5", "g", "kg", '"', "E", "L", "I"]
    for _ in range(20_000):
        understand("".join(source.choices(words, k=source.randrange(1, 9))))
