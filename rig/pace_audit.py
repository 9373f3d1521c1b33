"""When a stage passes the points of its path by the controller's own rule, compared with when it was seen there.

What the position audit cannot see, a detour between two reports or a feed that was misread as a slower one, costs time,
and the stage stays late for the rest of the stroke. Each report says that the stage was at a place at some time between
the question and the answer; from the kinematics follows when it would have had to start, and all reports of a stroke
have to agree on that but for the controller's clock, whose drift is allowed for. Being early is no failure here: too
high a speed is seen in the report itself.
"""

from bisect import bisect_left
from collections.abc import Sequence
from itertools import pairwise
from math import dist, inf
from typing import Final

from rig.dialects.grbl_settings import Axes, GrblSettings
from rig.virtual.kinematics import SpeedProfile, Vector, along, entry_speeds, junction_speed, trapezoid

DRIFT: Final = 0.01
"""By how much the controller's clock may be slow; ceramic resonators are within half of that."""
START_S: Final = 0.25
"""Latest start of the motion after its first line was sent [s]."""
LOOK_BACK_S: Final = 5.0
"""Lateness beyond which a place is not looked for any more [s]."""


class PaceAudit:
    """Planned times of one path in machine positions."""

    def __init__(self, settings: GrblSettings) -> None:
        """Expect a controller with such settings."""
        self.late_s = 0.0
        """By how much the stage was later than can be explained, at most since the last `begin` [s]."""
        self._settings = settings
        # as in the position audit: a place on the path is rounded to steps
        self._near_mm = 1.5 * dist((0.0, 0.0, 0.0), settings.step_mm) + 0.001
        self._moves: list[tuple[Axes, Axes]] = []
        self._profiles: list[SpeedProfile] = []
        self._ends_s: list[float] = []
        self._latest_start_s = inf
        self._seen_s = 0.0

    def begin(self, path_mm: Sequence[Axes], speeds_mm_s: Sequence[float], now_s: float) -> None:
        """Plan a path from rest to rest [mm], at a speed on each move [mm/s], that starts about now [s]."""
        self._moves = [(a, b) for a, b in pairwise(path_mm) if a != b]
        speeds = [speed for (a, b), speed in zip(pairwise(path_mm), speeds_mm_s, strict=True) if a != b]
        self._profiles = _profiles(self._moves, speeds, self._settings)
        self._ends_s, passed_s = [], 0.0
        for profile in self._profiles:
            passed_s += profile.duration_s
            self._ends_s.append(passed_s)
        self._latest_start_s, self._seen_s, self.late_s = now_s + START_S, now_s, 0.0

    def forget(self) -> None:
        """Judge nothing until the next `begin`, since the motion does not start from rest, or at a time not known."""
        self._moves = []

    def seen(self, position_mm: Axes, asked_s: float, heard_s: float) -> None:
        """Take note of a report [mm] that was asked for and heard at two times [s]."""
        if self._moves:
            latest_s = heard_s - self._latest_start_s + START_S
            if times_s := self._times_s(position_mm, latest_s - LOOK_BACK_S, latest_s):
                self._judge(min(times_s), max(times_s), asked_s, heard_s)

    def ended(self, pause_s: float, asked_s: float, heard_s: float) -> None:
        """Take note that the path and a pause [s] after it ended between two times [s]."""
        if self._moves:
            end_s = self._ends_s[-1] + pause_s
            self._judge(end_s, end_s, asked_s, heard_s)
            self.forget()

    def _judge(self, first_s: float, last_s: float, asked_s: float, heard_s: float) -> None:
        """Compare the first and the last planned time that a report can mean with when it was heard [s]."""
        latest_s = self._latest_start_s + DRIFT * (heard_s - self._seen_s)
        self.late_s = max(self.late_s, asked_s - last_s - latest_s)
        self._latest_start_s, self._seen_s = min(latest_s, heard_s - first_s), heard_s

    def _times_s(self, position_mm: Axes, from_s: float, to_s: float) -> list[float]:
        """Return the planned times between two [s] at which the stage is at a place: a path may pass it repeatedly."""
        times_s = []
        index = min(bisect_left(self._ends_s, to_s), len(self._ends_s) - 1)
        while index >= 0 and self._ends_s[index] >= from_s:
            passed = _part(position_mm, *self._moves[index], self._near_mm)
            if passed is not None:
                begun_s = self._ends_s[index] - self._profiles[index].duration_s
                planned_s = begun_s + _time_at(self._profiles[index], passed)
                if from_s <= planned_s <= to_s:
                    times_s.append(planned_s)
            index -= 1
        return times_s


def _profiles(
    moves: Sequence[tuple[Axes, Axes]], speeds_mm_s: Sequence[float], settings: GrblSettings
) -> list[SpeedProfile]:
    lengths = [dist(a, b) for a, b in moves]
    units: list[Vector] = []
    for (a, b), length in zip(moves, lengths, strict=True):
        units.append(((b[0] - a[0]) / length, (b[1] - a[1]) / length, (b[2] - a[2]) / length))
    accelerations = [along(unit, settings.acceleration_mm_s2) for unit in units]
    nominal = [min(speed, along(unit, settings.max_speed_mm_s)) for speed, unit in zip(speeds_mm_s, units, strict=True)]
    limits = [0.0]
    for index, (before, after) in enumerate(pairwise(units)):
        corner = junction_speed(before, after, settings.acceleration_mm_s2, settings.junction_deviation_mm)
        limits.append(min(corner, nominal[index], nominal[index + 1]))
    entries = entry_speeds(lengths, limits, accelerations, 0.0)
    return [
        trapezoid(length, entry_mm_s=entry, exit_mm_s=leave, limit_mm_s=limit, acceleration_mm_s2=acceleration)
        for length, (entry, leave), limit, acceleration in zip(
            lengths, pairwise(entries), nominal, accelerations, strict=True
        )
    ]


def _part(point: Axes, start: Axes, end: Axes, near_mm: float) -> float | None:
    """Return how far along a move a point lies [mm], or None if it is not near it."""
    length = dist(start, end)
    unit = [(b - a) / length for a, b in zip(start, end, strict=True)]
    passed = sum((c - a) * part for c, a, part in zip(point, start, unit, strict=True))
    passed = min(length, max(0.0, passed))
    foot = [a + passed * part for a, part in zip(start, unit, strict=True)]
    return passed if dist(point, foot) <= near_mm else None


def _time_at(profile: SpeedProfile, distance_mm: float) -> float:
    """Return when a profile has passed a distance [s], by halving."""
    low, high = 0.0, profile.duration_s
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if profile.at(middle)[0] < distance_mm else (low, middle)
    return high
