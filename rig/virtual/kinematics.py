"""Motion along a path with limited acceleration, in closed form: how fast corners may be taken, and when one is where.

Speeds at corners follow S. K. Jeon's junction deviation, the rule of Grbl's planner: the corner is taken as if on a
circle that touches both moves and passes the corner at a distance, the deviation.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, sqrt

Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True, slots=True)
class SpeedProfile:
    """Speeding up, keeping a speed and slowing down along a straight move, any part of which may be missing."""

    entry_mm_s: float
    peak_mm_s: float
    acceleration_mm_s2: float
    up_s: float
    keep_s: float
    down_s: float

    @property
    def duration_s(self) -> float:
        """Time for the whole move [s]."""
        return self.up_s + self.keep_s + self.down_s

    def at(self, time_s: float) -> tuple[float, float]:
        """Return distance [mm] and speed [mm/s] a time [s] after the start."""
        v, a = self.entry_mm_s, self.acceleration_mm_s2
        t = min(time_s, self.up_s)
        distance, speed = v * t + a * t * t / 2, v + a * t
        if time_s > self.up_s:
            t = min(time_s - self.up_s, self.keep_s)
            distance, speed = distance + self.peak_mm_s * t, self.peak_mm_s
        if time_s > self.up_s + self.keep_s:
            t = min(time_s - self.up_s - self.keep_s, self.down_s)
            distance, speed = distance + self.peak_mm_s * t - a * t * t / 2, max(0.0, self.peak_mm_s - a * t)
        return distance, speed


def trapezoid(
    length_mm: float, *, entry_mm_s: float, exit_mm_s: float, limit_mm_s: float, acceleration_mm_s2: float
) -> SpeedProfile:
    """Return the fastest profile over a length from one speed to another; the length must suffice for that."""
    a = acceleration_mm_s2
    highest = sqrt((entry_mm_s**2 + exit_mm_s**2) / 2 + a * length_mm)
    peak = max(min(limit_mm_s, highest), entry_mm_s, exit_mm_s)
    ramps = (2 * peak**2 - entry_mm_s**2 - exit_mm_s**2) / (2 * a)
    return SpeedProfile(
        entry_mm_s=entry_mm_s,
        peak_mm_s=peak,
        acceleration_mm_s2=a,
        up_s=(peak - entry_mm_s) / a,
        keep_s=max(0.0, length_mm - ramps) / peak if peak > 0 else 0.0,
        down_s=(peak - exit_mm_s) / a,
    )


def braking(length_mm: float, *, entry_mm_s: float, acceleration_mm_s2: float) -> tuple[SpeedProfile, float]:
    """Return the profile of slowing down at once over at most a length, and the speed left at its end [mm/s]."""
    left = sqrt(max(0.0, entry_mm_s**2 - 2 * acceleration_mm_s2 * length_mm))
    profile = SpeedProfile(
        entry_mm_s=entry_mm_s,
        peak_mm_s=entry_mm_s,
        acceleration_mm_s2=acceleration_mm_s2,
        up_s=0.0,
        keep_s=0.0,
        down_s=(entry_mm_s - left) / acceleration_mm_s2,
    )
    return profile, left


def entry_speeds(
    lengths_mm: Sequence[float], limits_mm_s: Sequence[float], accelerations_mm_s2: Sequence[float], start_mm_s: float
) -> list[float]:
    """Return the fastest speeds at the starts of consecutive moves and at their end, where it is 0 [mm/s].

    The first move starts at `start_mm_s`; `limits_mm_s` bound the other starts (the first is not looked at).
    """
    count = len(lengths_mm)
    speeds = [0.0] * (count + 1)
    for i in range(count - 1, 0, -1):
        reachable = sqrt(speeds[i + 1] ** 2 + 2 * accelerations_mm_s2[i] * lengths_mm[i])
        speeds[i] = min(limits_mm_s[i], reachable)
    speeds[0] = start_mm_s
    for i in range(count):
        reachable = sqrt(speeds[i] ** 2 + 2 * accelerations_mm_s2[i] * lengths_mm[i])
        speeds[i + 1] = min(speeds[i + 1], reachable)
    return speeds


def along(direction: Vector, limits: Vector) -> float:
    """Return what a limit on each axis allows along a direction (a unit vector)."""
    return min(limit / abs(part) for limit, part in zip(limits, direction, strict=True) if part)


def junction_speed(before: Vector, after: Vector, accelerations_mm_s2: Vector, deviation_mm: float) -> float:
    """Return the speed at a corner between two unit directions [mm/s]: infinite if straight on, 0 if back."""
    cosine = sum(a * b for a, b in zip(before, after, strict=True))
    if cosine > 0.999999:
        return inf
    if cosine < -0.999999:
        return 0.0
    turn = tuple(b - a for a, b in zip(before, after, strict=True))
    size = sqrt(sum(part * part for part in turn))
    acceleration = along((turn[0] / size, turn[1] / size, turn[2] / size), accelerations_mm_s2)
    sine_half = sqrt((1 + cosine) / 2)
    return sqrt(acceleration * deviation_mm * sine_half / (1 - sine_half))
