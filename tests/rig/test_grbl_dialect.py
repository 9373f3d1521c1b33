"""The words of Grbl: what is understood, and what is refused."""

import random
import time
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.errors import InputError
from rig.dialects.grbl import LINE_BYTES, Alarm, Banner, Error, GrblParser, Message, Ok, Setting, Status, Unknown
from rig.dialects.grbl_lines import encode_line, jog_line, move_line, offset_line

SAID = (
    b"\r\nGrbl 1.1h ['$' for help]\r\n[MSG:'$H'|'$X' to unlock]\r\nok\r\nerror:9\r\nALARM:2\r\n$100=400.000\r\n"
    b"<Hold:0|MPos:-1.000,2.500,-3.000|Bf:15,128|FS:120,0|WCO:0.000,0.000,0.000>\r\nwhat\r\n"
)
MEANT = [
    Banner(text="Grbl 1.1h ['$' for help]"),
    Message(name="MSG", text="'$H'|'$X' to unlock"),
    Ok(),
    Error(number=9),
    Alarm(number=2),
    Setting(number=100, value=400.0),
    Status(state="Hold", substate=0, machine_mm=(-1.0, 2.5, -3.0), free_moves=15, free_bytes=128, feed_mm_min=120.0),
    Unknown(text="what"),
]


@given(cuts=st.lists(st.integers(0, len(SAID)), max_size=6))
def test_events_do_not_depend_on_how_the_bytes_come(cuts: list[int]) -> None:
    parser, edges = GrblParser(), [0, *sorted(cuts), len(SAID)]
    events = [event for a, b in pairwise(edges) for event in parser.feed(SAID[a:b])]
    assert events == MEANT


@given(data=st.lists(st.binary(max_size=400), max_size=5))
def test_no_bytes_raise_and_lines_are_bounded(data: list[bytes]) -> None:
    parser = GrblParser()
    for part in data:
        for event in parser.feed(part):
            assert not isinstance(event, Unknown) or len(event.text) <= LINE_BYTES
    assert parser.feed(b"\nok\n")[-1] == Ok()


@given(position=st.integers(0, len(SAID) - 1), bit=st.integers(0, 7))
def test_a_flipped_bit_changes_few_events_and_raises_nothing(position: int, bit: int) -> None:
    spoiled = bytearray(SAID)
    spoiled[position] ^= 1 << bit
    events = GrblParser().feed(bytes(spoiled))
    assert len([event for event in events if event in MEANT]) >= len(MEANT) - 2


@pytest.mark.slow
def test_ten_million_bytes() -> None:
    chance, parser = random.Random(0), GrblParser()
    start, words = (
        time.perf_counter(),
        [b"<", b">", b"|", b"MPos:", b",", b"1.5", b"ok", b"\n", b"[", b"]", b"$1=", b"-"],
    )
    for _ in range(1000):
        noise = chance.randbytes(5000)
        grammar = b"".join(chance.choices(words, k=2200))
        parser.feed(noise + grammar)
    assert time.perf_counter() - start < 60


def test_moves_are_whole_lines_with_their_feed() -> None:
    assert move_line(speed_mm_s=2, x_mm=1.25, y_mm=-0.00001) == b"G1X1.25Y0F120\n"
    assert move_line(speed_mm_s=1 / 3, z_mm=-3) == b"G1Z-3F20\n"
    assert jog_line(speed_mm_s=1, x_mm=1) == b"$J=G21G90X1F60\n"
    assert offset_line(-100, -99.99996, -50) == b"G10L2P1X-100Y-100Z-50\n"


@pytest.mark.parametrize("text", ["G1X1?", "G1!", "~", "G1X1\rG1X2", "G1\n", "G1X½", "\x18", "G1" + "X" * 78])
def test_what_would_act_at_once_or_get_lost_is_refused(text: str) -> None:
    with pytest.raises(InputError):
        encode_line(text)
    assert len(encode_line("G1" + "X" * 77)) == 80
