"""The virtual controller against what genuine firmware was seen to do."""

import pytest

from rig.dialects.grbl_settings import GrblSettings
from rig.virtual.grbl import VirtualGrbl

SETTINGS = GrblSettings(
    steps_per_mm=(400.0, 400.0, 400.0),
    max_speed_mm_s=(20.0, 20.0, 5.0),
    acceleration_mm_s2=(100.0, 100.0, 100.0),
    travel_mm=(200.0, 200.0, 60.0),
)


class Bench:
    """A homed controller, its origin at (-100, -100, -30), and the time."""

    def __init__(self) -> None:
        self.device, self.now_s = VirtualGrbl(SETTINGS), 0.0
        self.say(b"$H\n", 60.0)
        self.say(b"G10L2P1X-100Y-100Z-30\nG1X0Y0F1200\n", 60.0)

    def say(self, data: bytes, then_s: float = 0.0) -> bytes:
        self.device.receive(data, self.now_s)
        self.now_s += then_s
        return self.device.send(self.now_s)


def test_it_is_locked_until_homed() -> None:
    device = VirtualGrbl(SETTINGS)
    device.receive(b"G1X1F60\n", 0.0)
    assert device.send(0.0).endswith(b"unlock]\r\nerror:9\r\n")
    assert device.offset_steps != (0, 0, 0)
    device.receive(b"$H\n?", 0.0)
    assert device.send(0.1) == b""  # no answer while it homes
    assert device.send(60.0) == b"ok\r\n"
    assert device.offset_steps == (0, 0, 0)
    assert device.true_mm() == (-1.0, -1.0, -1.0)


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        (b"G1X1", b"error:22"),
        (b"G1X10F100G1Y5F100", b"error:21"),
        (b"G1X10F100Y5F100", b"error:25"),
        (b"1X10", b"error:1"),
        (b"G1X", b"error:2"),
        (b"G2X1Y1R1", b"error:20"),
        (b"G4", b"error:28"),
        (b"G1X1F-3", b"error:4"),
        (b"G" * 90, b"error:11"),
        (b"$J=X500F100", b"error:15"),
        (b"$nonsense", b"error:3"),
        (b"", b"ok"),
        (b"(comment) g1 x1 f60 ; more", b"ok"),
    ],
)
def test_lines_and_their_answers(line: bytes, answer: bytes) -> None:
    bench = Bench()
    bench.say(b"\x18")
    assert bench.say(line + b"\n") == answer + b"\r\n"


def test_an_acknowledged_line_is_queued_and_not_executed() -> None:
    bench = Bench()
    assert bench.say(b"G1X20F60\n") == b"ok\r\n"
    assert bench.say(b"G4P0.01\n", 19.0) == b""
    assert bench.say(b"", 2.0) == b"ok\r\n"
    assert bench.device.true_mm()[0] == -80.0


def test_sixty_uncounted_lines_overflow_the_buffer() -> None:
    bench = Bench()
    answers = bench.say(b"".join(b"G1X%.1fF600\n" % (0.5 * k) for k in range(1, 61)), 60.0)
    assert answers.count(b"ok") < 40
    assert bench.device.lost_bytes > 200
    assert bench.device.true_mm()[0] < -75.0


def test_a_reset_soon_after_an_alarm_is_swallowed_and_a_stray_ok_comes_before_the_banner() -> None:
    bench = Bench()
    assert bench.say(b"G1X300F600\n", 0.2) == b"ALARM:2\r\n"
    assert bench.say(b"\x18?", 0.2) == b""
    assert bench.say(b"", 0.2) == b"[MSG:Reset to continue]\r\n"
    assert bench.say(b"?$X\n", 5.0) == b""
    assert bench.say(b"\x18").startswith(b"ok\r\n\r\nGrbl 1.1h")
    assert bench.device.true_mm() == (-100.0, -100.0, -1.0)


def test_hold_then_reset_keeps_the_position_and_a_reset_in_motion_does_not() -> None:
    bench = Bench()
    bench.say(b"G1X50F600\n", 1.0)
    assert bench.say(b"!?", 0.5).startswith(b"<Hold:1|")
    assert bench.say(b"?").startswith(b"<Hold:0|")
    assert bench.say(b"\x18").strip() == b"Grbl 1.1h ['$' for help]"
    assert bench.device.offset_steps == (0, 0, 0)
    bench.say(b"G1X50F600\n", 1.0)
    assert bench.say(b"\x18").startswith(b"ALARM:3\r\n")
    assert bench.device.offset_steps != (0, 0, 0)


def test_a_held_move_goes_on_to_its_end() -> None:
    bench = Bench()
    bench.say(b"G1X10F600\n", 0.5)
    bench.say(b"!", 5.0)
    assert bench.device.true_mm()[0] < -90.0
    bench.say(b"~", 5.0)
    assert bench.device.true_mm()[0] == -90.0


def test_mishaps_lose_the_position() -> None:
    bench = Bench()
    bench.device.schedule("hard limit", bench.now_s + 0.5)
    assert bench.say(b"G1X50F600\n", 0.7) == b"ok\r\nALARM:1\r\n"
    bench.say(b"", 1.0)
    assert b"ok" not in bench.say(b"\x18")  # no line was interrupted
    bench = Bench()
    bench.device.schedule("brown-out", bench.now_s + 0.5)
    assert b"Grbl 1.1h" in bench.say(b"G1X50F600\n", 0.7)
    assert bench.device.offset_steps != (0, 0, 0)
