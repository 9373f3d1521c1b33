"""Motion of the virtual controller against closed forms."""

from math import acos, cos, dist, inf, isclose, pi, sqrt

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from planner.program.timing import move_s
from rig.dialects.grbl_settings import GrblSettings
from rig.virtual.grbl_motion import MotionQueue
from rig.virtual.kinematics import entry_speeds, junction_speed, trapezoid

SETTINGS = GrblSettings(
    steps_per_mm=(400.0, 400.0, 400.0),
    max_speed_mm_s=(20.0, 20.0, 5.0),
    acceleration_mm_s2=(100.0, 100.0, 100.0),
    travel_mm=(200.0, 200.0, 60.0),
)
positive = st.floats(0.01, 100)


@given(length=positive, limit=positive, acceleration=positive)
def test_a_move_from_rest_to_rest_takes_the_time_of_the_program_s_own_timing(
    length: float, limit: float, acceleration: float
) -> None:
    profile = trapezoid(length, entry_mm_s=0, exit_mm_s=0, limit_mm_s=limit, acceleration_mm_s2=acceleration)
    assert profile.duration_s == pytest.approx(move_s(length, limit, acceleration))
    assert profile.at(profile.duration_s)[0] == pytest.approx(length)


@given(lengths=st.lists(st.floats(0.01, 5), min_size=1, max_size=8), limit=st.floats(0.1, 10))
def test_planned_speeds_can_be_reached_and_end_at_rest(lengths: list[float], limit: float) -> None:
    speeds = entry_speeds(lengths, [limit] * len(lengths), [100.0] * len(lengths), 0.0)
    assert speeds[-1] == 0
    for length, before, after in zip(lengths, speeds, speeds[1:], strict=False):
        assert abs(after**2 - before**2) <= 2 * 100 * length * (1 + 1e-9)
        assert after <= limit


def test_corners_are_taken_as_fast_as_the_deviation_allows() -> None:
    x, y, cubic = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (100.0, 100.0, 100.0)
    assert junction_speed(x, x, cubic, 0.01) == inf
    assert junction_speed(x, (-1.0, 0.0, 0.0), cubic, 0.01) == 0
    # a right angle: sine of half of it is 1/sqrt 2; along (-1, 1, 0) both axes accelerate, together sqrt 2 as fast
    half = sqrt(0.5)
    assert isclose(junction_speed(x, y, cubic, 0.01), sqrt(100 * sqrt(2) * 0.01 * half / (1 - half)))


def test_collinear_pieces_take_as_long_as_the_whole() -> None:
    def duration(pieces: int) -> float:
        queue = MotionQueue(SETTINGS, 15)
        for piece in range(1, pieces + 1):
            queue.add((12.0 * piece / pieces, 0.0, 0.0), 10.0)
        queue.start()
        queue.advance(100.0)
        return queue.dry_s[0]

    assert duration(1) == pytest.approx(move_s(12, 10, 100))
    assert duration(12) == pytest.approx(duration(1))


def test_moves_that_arrive_late_are_planned_from_the_speed_of_the_moment() -> None:
    queue = MotionQueue(SETTINGS, 15)
    queue.add((1.0, 0.0, 0.0), 10.0)
    queue.start()
    queue.advance(0.05)  # half way through the first half: 0.125 mm at 5 mm/s
    assert queue.speed_mm_s() == pytest.approx(5.0)
    queue.add((12.0, 0.0, 0.0), 10.0)
    queue.advance(100.0)
    assert queue.dry_s == [pytest.approx(move_s(12, 10, 100))]


def test_a_hold_brakes_over_the_ends_of_moves_and_going_on_reaches_the_target() -> None:
    queue = MotionQueue(SETTINGS, 15)
    for k in range(1, 11):
        queue.add((0.1 * k, 0.0, 0.0), 10.0)
    queue.start()
    queue.advance(0.1)  # 0.5 mm at 10 mm/s: exactly half way
    queue.brake()
    queue.advance(0.15)
    assert queue.state == "braking"
    queue.advance(10.0)
    assert queue.state == "still"
    assert queue.position_steps() == (400, 0, 0)  # the planned end: it was braking as hard as it can anyway
    queue.add((2.0, 0.0, 0.0), 10.0)
    queue.start()
    queue.advance(20.0)
    assert queue.position_steps() == (800, 0, 0)


def test_a_circle_of_short_moves_keeps_its_speed() -> None:
    from math import sin

    queue = MotionQueue(SETTINGS, 15)
    queue.place((4000, 0, 0))
    now = 0.0
    for k in range(1, 629):
        while queue.full:
            now = queue.next_s()
            queue.advance(now)
        queue.add((10 * cos(k / 100), 10 * sin(k / 100), 0.0), 2.0)
        queue.start()
    queue.advance(1000.0)
    assert queue.dry_s[-1] == pytest.approx(20 * pi / 2, rel=2e-3)
    assert len(queue.dry_s) == 1


direction = st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1)).filter(lambda v: dist(v, (0, 0, 0)) > 0.1)


@given(a=direction, b=direction, limits=st.tuples(positive, positive, positive), deviation=st.floats(0.001, 0.1))
def test_corners_by_the_circle_that_touches_both_moves(a, b, limits, deviation) -> None:
    """Grbl's `planner.c`: v^2 = a r on the circle of radius r that passes the corner at the deviation."""
    before, after = (tuple(part / dist(v, (0, 0, 0)) for part in v) for v in (a, b))
    turned = acos(max(-1.0, min(1.0, sum(p * q for p, q in zip(before, after, strict=True)))))
    assume(0.01 < turned < pi - 0.01)
    # the circle's centre is r / cos(turned / 2) from the corner, of which r + deviation reach it
    radius = deviation * cos(turned / 2) / (1 - cos(turned / 2))
    towards = tuple(q - p for p, q in zip(before, after, strict=True))
    size = dist(towards, (0, 0, 0))
    acceleration = min(limit * size / abs(part) for limit, part in zip(limits, towards, strict=True) if part)
    assert junction_speed(before, after, limits, deviation) == pytest.approx(sqrt(acceleration * radius), rel=1e-6)
