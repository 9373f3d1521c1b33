"""Marlin's words, and the stage's driver on the virtual one: golden lines, resends, faults."""

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.errors import InputError, RigError
from planner.program import Pass, load_machine
from rig.devices import Stage
from rig.dialects.marlin import (
    Busy,
    Event,
    Failure,
    Ok,
    Position,
    Resend,
    Started,
    StepsPerMm,
    Text,
    checksum,
    encode,
    understand,
)
from rig.dialects.marlin_settings import MarlinSettings
from rig.marlin_line import RESENDS
from rig.marlin_stage import MarlinStage
from rig.transport import Fault, FaultyTransport, SimulatedTransport, VirtualClock
from rig.virtual.marlin import VirtualMarlin

SETTINGS = MarlinSettings(
    steps_per_mm=(80.0, 80.0, 400.0),
    max_speed_mm_s=(20.0, 20.0, 5.0),
    acceleration_mm_s2=(100.0, 100.0, 100.0),
    travel_mm=(200.0, 200.0, 60.0),
)
ORIGIN = (100.0, 100.0, 10.0)
STROKE = Pass(points_mm=((1, 1), (5, 1), (5, 4.3)), speed_mm_s=(2, 1), load_g=(1,), side="convex")
END = (105.0, 104.3, 12.0)


def stage_on(device: VirtualMarlin, *faults: Fault) -> tuple[MarlinStage, VirtualClock]:
    clock = VirtualClock()
    line = FaultyTransport(SimulatedTransport(device, clock), faults)
    return MarlinStage(line, limits=load_machine().stage, controller=SETTINGS, origin_mm=ORIGIN), clock


def scratch_one(stage: MarlinStage, stroke: Pass = STROKE) -> None:
    stage.lift()
    stage.wait_idle(60)
    stage.move_to(*stroke.points_mm[0])
    stage.wait_idle(60)
    stage.scratch(stroke)
    stage.wait_idle(3600)
    stage.lift()
    stage.wait_idle(60)


def test_check_vectors() -> None:
    assert encode("M110 N0", 0) == b"N0 M110 N0*125\n"
    assert encode("G28", 1) == b"N1 G28*18\n"
    assert checksum(b"N1 G28") == 18


@pytest.mark.parametrize("command", ["g28", "G1 X1*3", "N3 G28", "G1 X1\nM112", "G1 X½", "", "G1" + " X1.0000" * 12])
def test_what_is_no_command_is_refused(command: str) -> None:
    with pytest.raises(InputError):
        encode(command, 7)


@pytest.mark.parametrize(
    ("line", "event"),
    [
        ("ok", Ok()),
        ("ok N5 P15 B3", Ok()),
        ("Resend: 31", Resend(number=31)),
        ("rs N31", Resend(number=31)),
        ("echo:busy: processing", Busy()),
        ("start", Started()),
        ("Error:checksum mismatch, Last Line: 30", Failure(text="Error:checksum mismatch, Last Line: 30")),
        ("X:1.00 Y:2.00 Z:-3.00 E:0.00 Count X:80 Y:160 Z:-1200", Position(steps=(80, 160, -1200))),
        ("echo:  M92 X80.00 Y80.00 Z400.00 E500.00", StepsPerMm(steps_per_mm=(80.0, 80.0, 400.0))),
        ("oki", Text(text="oki")),
    ],
)
def test_events(line: str, event: Event) -> None:
    assert understand(line) == event


@given(st.text(max_size=100))
def test_any_line_is_survived(line: str) -> None:
    understand(line)


@pytest.mark.parametrize("count", [5_000, pytest.param(300_000, marks=pytest.mark.slow)])
def test_lines_of_the_grammar_in_bulk(count: int) -> None:
    source = random.Random(5)
    words = [
        "ok",
        "Resend: ",
        "X:",
        " Y:",
        "Z:",
        "1.00 ",
        " Count ",
        "-12",
        "echo:",
        "M92",
        "busy:",
        "Error:",
        "9" * 12,
    ]
    for _ in range(count):
        understand("".join(source.choices(words, k=source.randrange(1, 12))))


def test_it_homes_scratches_and_is_where_it_should_be() -> None:
    device = VirtualMarlin(SETTINGS)
    stage, clock = stage_on(device)
    assert isinstance(stage, Stage)
    with pytest.raises(RigError, match="home it"):
        stage.lift()
    stage.home()
    assert stage.identify() == "Marlin 2.1.2.4"
    scratch_one(stage)
    assert device.true_mm() == pytest.approx(END, abs=0.01)
    assert stage.position_mm() == pytest.approx((5, 4.3, 2), abs=0.01)
    assert stage.resends == 0
    # lifted, over, lowered, two segments, lifted
    assert device.executed.count("G1") == 6
    assert 4 / 2 + 3.3 < clock.now_s() < 200


def test_a_long_stroke_lives_on_the_keep_alive_and_never_starves() -> None:
    device = VirtualMarlin(SETTINGS)
    stage, _ = stage_on(device)
    stage.home()
    points = tuple((0.2 * k, 0.0) for k in range(251))
    slow = Pass(points_mm=(*points, (60.0, 0.0)), speed_mm_s=(2.0,) * 250 + (0.1,), load_g=(1,), side="convex")
    scratch_one(stage, slow)
    assert device.true_mm() == pytest.approx((160.0, 100.0, 12.0), abs=0.01)
    assert device.lost_bytes == 0
    assert stage.resends == 0
    # lift, move over, stroke, lift: dry at the end of each and, where nothing follows the first line, after that
    assert len(device.motion.dry_s) == 4


def test_wrong_steps_and_leaving_the_reach_are_told() -> None:
    other = MarlinSettings(**{**vars(SETTINGS), "steps_per_mm": (100.0, 80.0, 400.0)})
    with pytest.raises(RigError, match=r"\(100\.0, 80\.0, 400\.0\), expected \(80\.0"):
        stage_on(VirtualMarlin(other))[0].home()
    stage, _ = stage_on(VirtualMarlin(SETTINGS))
    stage.home()
    stage.lift()
    stage.wait_idle(60)
    with pytest.raises(RigError, match=r"x at 220 mm; allowed is 0 to 200"):
        stage.move_to(120, 0)


def test_a_stop_loses_the_position() -> None:
    device = VirtualMarlin(SETTINGS)
    stage, clock = stage_on(device)
    stage.home()
    stage.lift()
    stage.wait_idle(60)
    stage.move_to(0, 0)
    clock.sleep(1.0)
    stage.stop()
    stopped = device.true_mm()
    clock.sleep(10.0)
    device.next_event_s(clock.now_s())
    assert device.true_mm() == stopped
    with pytest.raises(RigError, match="home it"):
        stage.lift()
    stage.home()
    scratch_one(stage)
    assert device.true_mm() == pytest.approx(END, abs=0.01)


def test_a_controller_that_starts_anew_is_told() -> None:
    device = VirtualMarlin(SETTINGS)
    stage, clock = stage_on(device)
    stage.home()
    stage.lift()
    device.brown_out(clock.now_s() + 0.1)
    with pytest.raises(RigError, match=r"started anew|Home XYZ|ended at"):
        stage.wait_idle(60)


@pytest.mark.parametrize("kind", ["drop", "flip", "duplicate", "merge", "delay"])
@pytest.mark.parametrize("way", ["out", "in"])
def test_a_fault_is_repaired_or_told_and_no_line_is_done_twice(kind, way) -> None:
    repaired = 0
    for at in range(1, 700 if way == "out" else 1300, 7 if way == "out" else 13):
        device = VirtualMarlin(SETTINGS)
        stage, _ = stage_on(device, Fault(kind=kind, way=way, at=at, bit=at % 7, delay_s=7.0))
        try:
            stage.home()
            scratch_one(stage)
        except RigError:
            continue
        repaired += 1
        assert device.true_mm() == pytest.approx(END, abs=0.01), at
        assert device.executed.count("G1") == 6, at
    assert repaired > 30


def test_a_line_that_never_arrives_whole_is_given_up() -> None:
    device = VirtualMarlin(SETTINGS)
    stage, clock = stage_on(device)
    stage.home()
    stage.lift()
    stage.wait_idle(60)

    class Noise:
        def __init__(self, line) -> None:
            self._line, self.clock, self.read, self.close = line, line.clock, line.read, line.close

        def write(self, data: bytes) -> None:
            self._line.write(data.replace(b"G1", b"G3"))

    stage._line._transport = Noise(stage._line._transport)
    before_s = clock.now_s()
    with pytest.raises(RigError, match=f"after {RESENDS} repetitions"):
        stage.move_to(0, 0)
    assert clock.now_s() - before_s < 20
