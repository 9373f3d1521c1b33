"""The stage's driver on the virtual controller: golden bytes, soak, long strokes, faults, and a real terminal."""

import subprocess
import sys
from collections.abc import Iterable
from contextlib import suppress
from math import cos, sin
from pathlib import Path

import pytest

from planner.errors import RigError
from planner.program import Pass, load_machine
from rig.devices import Stage
from rig.dialects.grbl_settings import GrblSettings
from rig.grbl_stage import GrblStage
from rig.transport import (
    Fault,
    FaultyTransport,
    LoggedTransport,
    SerialTransport,
    SimulatedTransport,
    Transport,
    VirtualClock,
    read_wire_log,
)
from rig.virtual.grbl import VirtualGrbl

SETTINGS = GrblSettings(
    steps_per_mm=(400.0, 400.0, 400.0),
    max_speed_mm_s=(20.0, 20.0, 5.0),
    acceleration_mm_s2=(100.0, 100.0, 100.0),
    travel_mm=(200.0, 200.0, 60.0),
)
ORIGIN = (-100.0, -100.0, -50.0)
STROKE = Pass(points_mm=((1, 1), (5, 1), (5, 4.3333)), speed_mm_s=(2, 1), load_g=(1,), side="convex")
GOLDEN = (
    b"$I\n$$\n$H\nG21G90G94G17G54\n$#\nG10L2P1X-100Y-100Z-50\n$#\nG1Z2F300\nG4P0.01\nG1X1Y1F1200\nG4P0.01\n"
    b"G1Z0F300\nG1X5Y1F120\nG1X5Y4.3333F60\nG4P0.01\nG1Z2F300\nG4P0.01\n"
)


def stage_on(line: Transport) -> GrblStage:
    return GrblStage(line, limits=load_machine().stage, controller=SETTINGS, origin_mm=ORIGIN)


def simulated(faults: Iterable[Fault] = ()) -> tuple[GrblStage, VirtualGrbl, VirtualClock]:
    device, clock = VirtualGrbl(SETTINGS), VirtualClock()
    return stage_on(FaultyTransport(SimulatedTransport(device, clock), faults)), device, clock


def scratch_one(stage: Stage, stroke: Pass = STROKE) -> None:
    stage.lift()
    stage.wait_idle(60)
    stage.move_to(*stroke.points_mm[0])
    stage.wait_idle(60)
    stage.scratch(stroke)
    stage.wait_idle(3600)
    stage.lift()
    stage.wait_idle(60)


def circle(count: int, step_mm: float, speed_mm_s: float) -> Pass:
    points = tuple((30 * cos(k * step_mm / 30), 30 * sin(k * step_mm / 30)) for k in range(count + 1))
    return Pass(points_mm=points, speed_mm_s=(speed_mm_s,) * count, load_g=(1,), side="convex")


def lines_of(path: Path) -> bytes:
    """Bytes sent, without the questions for the status: their number depends on the clock."""
    return read_wire_log(path, "out").replace(b"?", b"")


def test_golden_bytes_and_where_they_take_the_post(tmp_path: Path) -> None:
    device, clock = VirtualGrbl(SETTINGS), VirtualClock()
    stage = stage_on(LoggedTransport(SimulatedTransport(device, clock), tmp_path / "wire.jsonl"))
    assert isinstance(stage, Stage)
    stage.home()
    scratch_one(stage)
    assert lines_of(tmp_path / "wire.jsonl") == GOLDEN
    assert stage.position_mm() == pytest.approx((5, 4.3333, 2), abs=2e-3)
    assert device.true_mm() == pytest.approx((-95, -95.6667, -48), abs=2e-3)
    stage.close()
    # at 5 Hz at most: fewer questions than five a second, and one for each verification
    assert read_wire_log(tmp_path / "wire.jsonl", "out").count(b"?") < 5 * clock.now_s() + 10


def test_the_same_bytes_over_a_terminal_to_another_process(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "rig.transport.pty_server", "grbl", "--speed", "20"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        try:
            port = server.stdout.readline().strip()
            stage = stage_on(LoggedTransport(SerialTransport(port, 115200), tmp_path / "wire.jsonl"))
            stage.home()
            scratch_one(stage)
            assert stage.position_mm() == pytest.approx((5, 4.3333, 2), abs=2e-3)
            stage.close()
        finally:
            server.terminate()
    assert lines_of(tmp_path / "wire.jsonl") == GOLDEN


def test_a_stroke_of_ten_minutes_is_legal_and_never_starves() -> None:
    stage, device, clock = simulated()
    stage.home()
    scratch_one(stage, circle(3000, 0.1, 0.5))
    assert clock.now_s() > 600
    assert device.lost_bytes == 0
    assert len(device.motion.dry_s) == 4  # at the end of each operation and nowhere else
    assert stage.most_in_flight_bytes <= 127


class SlowHost:
    """Line to a host that has other things to do after everything it hears."""

    def __init__(self, line: SimulatedTransport, late_s: float) -> None:
        self._line, self._late_s = line, late_s
        self.clock, self.write, self.close = line.clock, line.write, line.close

    def read(self, timeout_s: float) -> bytes:
        data = self._line.read(timeout_s)
        self.clock.sleep(self._late_s if data else 0.0)
        return data


def starved(late_s: float) -> int:
    """Scratch 60 mm at 2 mm/s in moves of 0.1 mm, and return how often the queue ran empty within."""
    device, clock = VirtualGrbl(SETTINGS), VirtualClock()
    stage = stage_on(SlowHost(SimulatedTransport(device, clock), late_s))
    stage.home()
    with suppress(RigError):  # much too late is told
        scratch_one(stage, circle(600, 0.1, 2.0))
    assert device.lost_bytes == 0
    assert stage.most_in_flight_bytes <= 127
    return len(device.motion.dry_s) - 4  # at the end of each operation


def test_a_host_may_be_late_by_what_its_bytes_in_flight_last() -> None:
    # 127 bytes are six lines of 50 ms each
    assert starved(0.05) == starved(0.15) == 0
    assert starved(0.6) > 10


@pytest.mark.slow
def test_a_soak_of_100_000_lines() -> None:
    stage, device, _ = simulated()
    stage.home()
    scratch_one(stage, circle(100_000, 0.05, 2.0))
    assert device.lost_bytes == 0
    assert len(device.motion.dry_s) == 4
    assert 100 < stage.most_in_flight_bytes <= 127


def test_it_stops_with_the_position_kept_and_goes_on() -> None:
    stage, device, clock = simulated()
    stage.home()
    stage.lift()
    stage.wait_idle(60)
    stage.move_to(0, 0)
    clock.sleep(1.0)
    before_s = clock.now_s()
    stage.stop()
    assert clock.now_s() - before_s < 1.0
    assert device.offset_steps == (0, 0, 0)
    assert device.state == "Idle"
    stage.move_to(0, 0)
    stage.wait_idle(60)
    assert device.true_mm() == (-100.0, -100.0, -48.0)


def test_it_refuses_what_would_be_unsafe() -> None:
    stage, device, _ = simulated()
    with pytest.raises(RigError, match="home it"):
        stage.lift()
    stage.home()
    with pytest.raises(RigError, match=r"x at 20 mm; allowed is -200 to 0"):
        stage.move_to(120, 0)
    with pytest.raises(RigError, match="move there first"):
        stage.scratch(STROKE)
    stage.move_to(1, 1)
    stage.wait_idle(60)
    stage.scratch(STROKE)
    stage.wait_idle(60)
    with pytest.raises(RigError, match="lift it"):
        stage.move_to(0, 0)
    assert device.true_mm()[2] == -50.0


def test_settings_that_were_changed_and_failed_homing_are_told() -> None:
    stage, device, _ = simulated()
    device.numbers[100] = 80.0
    with pytest.raises(RigError, match=r"\$100 is 80.*expected 400"):
        stage.home()
    device = VirtualGrbl(SETTINGS, homing_alarm=9)
    with pytest.raises(RigError, match="homing found no limit switch"):
        stage_on(SimulatedTransport(device, VirtualClock())).home()


def test_silence_is_not_taken_for_a_stage() -> None:
    class Nobody:
        def receive(self, data: bytes, now_s: float) -> None: ...

        def send(self, now_s: float) -> bytes:
            return b""

        def next_event_s(self, now_s: float) -> float:
            return float("inf")

    with pytest.raises(RigError, match="does not answer"):
        stage_on(SimulatedTransport(Nobody(), VirtualClock())).identify()


@pytest.mark.parametrize("mishap", ["hard limit", "brown-out"])
def test_mishaps_in_a_stroke_want_homing(mishap) -> None:
    stage, device, clock = simulated()
    stage.home()
    stage.move_to(1, 1)
    stage.wait_idle(60)
    stage.scratch(STROKE)
    device.schedule(mishap, clock.now_s() + 12.0)
    with pytest.raises(RigError):
        stage.wait_idle(60)
    with pytest.raises(RigError, match="home it"):
        stage.lift()
    stage.home()
    scratch_one(stage)
    assert device.true_mm() == pytest.approx((-95, -95.6667, -48), abs=2e-3)


def outcome(fault: Fault) -> tuple[str, VirtualGrbl]:
    """Scratch one stroke with a fault on the wire: `done` or `told`, and the controller."""
    stage, device, _ = simulated([fault])
    try:
        stage.home()
        scratch_one(stage)
    except RigError:
        return "told", device
    return "done", device


def test_a_flipped_bit_that_grbl_obeys_is_caught_by_the_audit() -> None:
    sent = GOLDEN.index(b"G1X1Y1")
    # bit 2 of the 1 after X makes it 5: acknowledged, executed, wrong
    faults = [Fault(kind="flip", way="out", at=sent + extra, bit=2) for extra in range(3, 40)]
    ends = [outcome(fault) for fault in faults]
    assert any(end == "told" for end, _ in ends)
    for end, device in ends:
        assert end == "told" or device.true_mm() == pytest.approx((-95, -95.6667, -48), abs=2e-3)


@pytest.mark.parametrize("kind", ["drop", "flip", "duplicate", "merge", "delay", "unplug"])
@pytest.mark.parametrize("way", ["out", "in"])
def test_no_fault_ends_in_a_silent_wrong_position(kind, way) -> None:
    last = len(GOLDEN) + 60 if way == "out" else 2600
    for at in range(1, last, 7 if way == "out" else 61):
        fault = Fault(kind=kind, way=way, at=at, bit=at % 8, delay_s=1.0)
        end, device = outcome(fault)
        assert end == "told" or device.true_mm() == pytest.approx((-95, -95.6667, -48), abs=2e-3), fault


class Misreader:
    """Line on which one feed becomes another."""

    def __init__(self, line: Transport) -> None:
        self._line, self.clock, self.read, self.close = line, line.clock, line.read, line.close

    def write(self, data: bytes) -> None:
        self._line.write(data.replace(b"F120\n", b"F160\n"))


def test_a_feed_that_was_misread_is_seen_on_the_way() -> None:
    stage = stage_on(Misreader(SimulatedTransport(VirtualGrbl(SETTINGS), VirtualClock())))
    stage.home()
    with pytest.raises(RigError, match=r"moved at 2.66667 mm/s where 2 were told"):
        scratch_one(stage)
