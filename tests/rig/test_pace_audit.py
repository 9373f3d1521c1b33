"""What the position audit cannot see shows in the time: detours between reports, slow feeds, starving; no more does."""

from math import cos, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.errors import RigError
from planner.program import Pass, load_machine
from rig.dialects.grbl_settings import GrblSettings
from rig.grbl_stage import GrblStage
from rig.transport import SimulatedTransport, Transport, VirtualClock
from rig.virtual.grbl import VirtualGrbl

SETTINGS = GrblSettings(
    steps_per_mm=(400.0, 400.0, 400.0),
    max_speed_mm_s=(20.0, 20.0, 5.0),
    acceleration_mm_s2=(100.0, 100.0, 100.0),
    travel_mm=(200.0, 200.0, 60.0),
)
TOLERANCE_S = 0.05


class Spoiled:
    """Line on which some words become others, and to a host that is late after everything that it hears."""

    def __init__(self, line: Transport, words: dict[bytes, bytes], late_s: float) -> None:
        self._line, self._words, self._late_s = line, words, late_s
        self.clock, self.close = line.clock, line.close

    def write(self, data: bytes) -> None:
        for old, new in self._words.items():
            data = data.replace(old, new)
        self._line.write(data)

    def read(self, timeout_s: float) -> bytes:
        data = self._line.read(timeout_s)
        self.clock.sleep(self._late_s if data else 0.0)
        return data


def scratch(
    stroke: Pass, words: dict[bytes, bytes] | None = None, *, late_s: float = 0.0, tolerance_s: float = TOLERANCE_S
) -> tuple[GrblStage, VirtualGrbl]:
    device = VirtualGrbl(SETTINGS)
    stage = GrblStage(
        Spoiled(SimulatedTransport(device, VirtualClock()), words or {}, late_s),
        limits=load_machine().stage,
        controller=SETTINGS,
        origin_mm=(-100.0, -100.0, -50.0),
        pace_tolerance_s=tolerance_s,
    )
    stage.home()
    stage.lift()
    stage.wait_idle(60)
    stage.move_to(*stroke.points_mm[0])
    stage.wait_idle(60)
    stage.scratch(stroke)
    stage.wait_idle(3600)
    return stage, device


def line_of(count: int, segment_mm: float, speed_mm_s: float) -> Pass:
    points = tuple((round(segment_mm * k, 4), 0.0) for k in range(count + 1))
    return Pass(points_mm=points, speed_mm_s=(speed_mm_s,) * count, load_g=(1,), side="convex")


@given(
    st.lists(st.tuples(st.floats(-20, 20), st.floats(-20, 20)), min_size=2, max_size=12),
    st.floats(0.5, 10.0),
    st.sampled_from([0.0, 0.03, 0.2]),
)
@settings(max_examples=40, deadline=None)
def test_no_good_stroke_is_late(points, speed_mm_s, late_s) -> None:
    points = tuple((round(x, 3), round(y, 3)) for x, y in points)
    speeds = tuple(speed_mm_s * (1 + 0.5 * (k % 2)) for k in range(len(points) - 1))
    stroke = Pass(points_mm=points, speed_mm_s=speeds, load_g=(1,), side="convex")
    stage, _ = scratch(stroke, late_s=late_s)
    assert stage.late_s < 0.02


@pytest.mark.parametrize(
    "points",
    [
        [(0, 0), (8, 0), (0, 0), (8, 0)],
        [(0.5 * k, (k % 2) * 3.0) for k in range(30)],
        [(30 * cos(0.003 * k), 30 * sin(0.003 * k)) for k in range(400)],
    ],
    ids=["there and back", "zigzag", "circle"],
)
def test_paths_that_come_by_the_same_place_again_and_short_moves_are_in_time(points) -> None:
    stroke = Pass(points_mm=tuple(points), speed_mm_s=(2.0,) * (len(points) - 1), load_g=(1,), side="convex")
    stage, _ = scratch(stroke)
    assert stage.late_s < 0.03


def test_a_vertex_that_was_misread_between_two_reports_costs_time_for_ever() -> None:
    stroke = line_of(200, 0.1, 2.0)
    for vertex in range(40, 60):
        x_mm = round(0.1 * vertex, 1)
        # a bit of the tenths: 4.1 becomes 4.5, or 4.5 becomes 4.1, there and back within a tenth of a second or two
        shown = f"G1X{x_mm:g}Y0F120\n".encode()
        wrong = f"G1X{round(x_mm + (0.4 if int(10 * x_mm) % 10 < 4 else -0.4), 1):g}Y0F120\n".encode()
        with pytest.raises(RigError, match=r"later than planned|off its path"):
            scratch(stroke, {shown: wrong})


def test_a_feed_that_was_misread_as_a_slower_one() -> None:
    with pytest.raises(RigError, match=r"later than planned \(allowed are 0\.05\)"):
        scratch(line_of(4, 5.0, 2.0), {b"G1X10Y0F120\n": b"G1X10Y0F100\n"})
    with pytest.raises(RigError, match="later than planned"):
        scratch(line_of(1, 3.0, 2.0), {b"F120\n": b"F110\n"})


def test_starving_is_told() -> None:
    stroke = line_of(200, 0.1, 2.0)
    with pytest.raises(RigError, match="was not fed in time"):
        scratch(stroke, late_s=0.5)
    stage, device = scratch(stroke, late_s=0.5, tolerance_s=float("inf"))
    assert stage.late_s > 0.3  # a report of a late host may be an old one
    assert len(device.motion.dry_s) > 10
