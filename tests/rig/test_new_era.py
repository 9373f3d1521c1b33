"""What New Era pumps say and hear, as bytes."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.errors import InputError
from rig.dialects.new_era import (
    LONGEST_REPLY,
    Alarm,
    PumpError,
    Reply,
    ReplyParser,
    Status,
    dispensed,
    encode,
    number,
    packet,
    volume_argument,
    volume_ml,
    volume_units,
)

MANUAL_SAF0 = bytes.fromhex("02 08 53 41 46 30 55 43 03")


def test_check_vector_of_the_manual() -> None:
    assert packet(b"SAF0") == MANUAL_SAF0


def test_commands_in_both_modes() -> None:
    assert encode("DIS", address=0, safe=False) == b"0DIS\r"
    assert encode("VOL1.500", address=12, safe=False) == b"12VOL1.500\r"
    assert encode("DIS", address=0, safe=True) == packet(b"0DIS")


@pytest.mark.parametrize("command", ["DIS\r", "VOL 1", "vol1", "RUN\n0RUN", "VOL1,5", "DIA\xb2", "A" * 41])
def test_what_could_be_taken_for_another_command_is_refused(command: str) -> None:
    with pytest.raises(InputError, match="cannot be sent"):
        encode(command, address=0, safe=False)


@pytest.mark.parametrize(
    ("value", "text"),
    [(0, "0.000"), (1.5, "1.500"), (9.9996, "10.00"), (99.996, "100.0"), (999.96, "1000"), (9999.4, "9999")],
)
def test_numbers_have_four_digits_and_three_decimals_at_most(value: float, text: str) -> None:
    assert number(value) == text


@pytest.mark.parametrize("value", [-0.1, 9999.5, float("nan"), float("inf")])
def test_numbers_that_the_pump_cannot_read(value: float) -> None:
    with pytest.raises(InputError, match="0 to 9999"):
        number(value)


def test_volumes_in_the_units_of_the_syringe() -> None:
    assert volume_argument(1.5, "ML") == "1.500"
    assert volume_argument(1.5, "UL") == "1500"
    assert volume_ml("1500.UL") == pytest.approx(1.5)
    assert volume_units("1500.UL") == "UL"
    with pytest.raises(InputError, match="below its resolution"):
        volume_argument(0.0004, "ML")  # VOL0 would pump without end


def test_counters_and_their_step() -> None:
    counters = dispensed("I0.340W12.00ML")
    assert (counters.infused_ml, counters.withdrawn_ml) == (0.34, 12.0)
    assert counters.net_ml == pytest.approx(-11.66)
    assert counters.resolution_ml == pytest.approx(0.01)
    assert dispensed("I340.0W1200.UL").resolution_ml == pytest.approx(1e-3)


REPLIES = {
    b"00S": Reply(address=0, status=Status.STOPPED),
    b"07II0.340W0.000ML": Reply(address=7, status=Status.INFUSING, data="I0.340W0.000ML"),
    b"00S?": Reply(address=0, status=Status.STOPPED, error=PumpError.UNKNOWN),
    b"00P?OOR": Reply(address=0, status=Status.PAUSED, error=PumpError.OUT_OF_RANGE),
    b"00A?R": Reply(address=0, alarm=Alarm.RESET),
    b"00SNE1000V3.923": Reply(address=0, status=Status.STOPPED, data="NE1000V3.923"),
}


def framed(text: bytes, safe: bool) -> bytes:
    return packet(text) if safe else b"\x02" + text + b"\x03"


@pytest.mark.parametrize("safe", [False, True])
def test_replies_arrive_whole_whatever_the_pieces(safe: bool) -> None:
    line = b"noise".join(framed(text, safe) for text in REPLIES)
    for size in (1, 3, len(line)):
        parser = ReplyParser(safe=safe)
        found = [reply for i in range(0, len(line), size) for reply in parser.feed(line[i : i + size])]
        assert found == list(REPLIES.values())
        assert parser.discarded == 5 * len(b"noise")


@pytest.mark.parametrize("safe", [False, True])
def test_a_truncated_reply_does_not_swallow_the_next(safe: bool) -> None:
    parser = ReplyParser(safe=safe)
    assert parser.feed(framed(b"00SNE1000V3.923", safe)[:-4]) == []
    assert parser.feed(framed(b"00S", safe) * 3)[-1] == Reply(address=0, status=Status.STOPPED)


def test_every_single_flipped_bit_is_noticed_in_safe_mode() -> None:
    whole = packet(b"00SI0.340W0.000ML")
    for bit in range(8 * len(whole)):
        flipped = bytearray(whole)
        flipped[bit // 8] ^= 1 << bit % 8
        assert ReplyParser(safe=True).feed(bytes(flipped)) == []


def test_a_reply_answers_only_what_has_its_form() -> None:
    counters = Reply(address=0, status=Status.STOPPED, data="I0.340W0.000ML")
    assert counters.answers("DIS")
    assert not counters.answers("VER")
    assert not counters.answers("RUN")
    assert Reply(address=0, status=Status.INFUSING).answers("RUN")
    assert not Reply(address=0, alarm=Alarm.STALL).answers("RUN")
    assert not Reply(address=0, status=Status.STOPPED, error=PumpError.NOT_NOW).answers("RUN")


@settings(max_examples=60, deadline=None)
@given(st.lists(st.one_of(st.binary(max_size=40), st.sampled_from([*REPLIES, b"\x02", b"\x03"]))), st.booleans())
def test_any_bytes_are_survived(pieces: list[bytes], safe: bool) -> None:
    parser = ReplyParser(safe=safe)
    for piece in pieces:
        parser.feed(piece)
        assert len(parser._buffer) <= 2 * LONGEST_REPLY
    parser.forget()
    assert parser.feed(framed(b"00S", safe)) == [Reply(address=0, status=Status.STOPPED)]


@pytest.mark.slow
@pytest.mark.parametrize("safe", [False, True])
def test_ten_million_bytes_are_survived(safe: bool) -> None:
    source = random.Random(5)
    wholes = [framed(text, safe) for text in REPLIES]
    parser, count = ReplyParser(safe=safe), 0
    while count < 10_000_000:
        noise = bytes(source.choices(b"\x02\x03\x07\x15?AISW0123.ML\xff", k=source.randrange(300)))
        piece = noise + source.choice(wholes) + source.randbytes(source.randrange(700))
        parser.feed(piece)
        count += len(piece)
        assert len(parser._buffer) <= 2 * LONGEST_REPLY
