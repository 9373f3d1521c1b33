"""The motion of a virtual Grbl: its queue of moves, executed in exact pieces on virtual time."""

from collections import deque
from dataclasses import dataclass
from math import inf, sqrt
from typing import Literal

from rig.dialects.grbl_settings import Axes, GrblSettings
from rig.virtual.kinematics import (
    SpeedProfile,
    Vector,
    along,
    braking,
    entry_speeds,
    junction_speed,
    trapezoid,
)

Steps = tuple[int, int, int]


@dataclass(kw_only=True, slots=True)
class Move:
    """One straight move in the queue."""

    start: Steps
    end: Steps
    unit: Vector
    length_mm: float
    nominal_mm_s: float
    acceleration_mm_s2: float
    entry_limit_mm_s: float


class MotionQueue:
    """Moves in order, the first under way; every time is exact, nothing is stepped.

    `trace` and `dry_s` are for tests: where the axes really were, and when the queue ran empty.
    """

    def __init__(self, settings: GrblSettings, capacity: int) -> None:
        self.settings = settings
        self.capacity = capacity
        self.moves: deque[Move] = deque()
        self.state: Literal["still", "moving", "braking"] = "still"
        self.position: Steps = (0, 0, 0)
        """Where the last finished or halted move ended, as the controller counts [steps]."""
        self.planned: Steps = (0, 0, 0)
        """Where the last queued move will end [steps]."""
        self.trace: list[tuple[float, Steps]] = []
        """Ends of the executed moves: time [s] and position [steps]."""
        self.dry_s: list[float] = []
        self._now = 0.0
        self._since = 0.0
        self._done_mm = 0.0
        self._profile: SpeedProfile | None = None
        self._left = 0.0
        self._exits: deque[float] = deque()
        self._stale = False

    @property
    def full(self) -> bool:
        """Whether the queue takes no more moves."""
        return len(self.moves) >= self.capacity

    def add(self, target_mm: Axes, speed_mm_s: float) -> None:
        """Queue a move to a position [mm] at a speed [mm/s]; one shorter than half a step is none."""
        settings = self.settings
        x, y, z = (round(mm * per) for mm, per in zip(target_mm, settings.steps_per_mm, strict=True))
        end, start = (x, y, z), self.planned
        delta = [(b - a) / per for a, b, per in zip(start, end, settings.steps_per_mm, strict=True)]
        length = sqrt(sum(part * part for part in delta))
        if length == 0:
            return
        unit = (delta[0] / length, delta[1] / length, delta[2] / length)
        nominal = min(speed_mm_s, along(unit, settings.max_speed_mm_s))
        limit = 0.0
        if self.moves:
            last = self.moves[-1]
            corner = junction_speed(last.unit, unit, settings.acceleration_mm_s2, settings.junction_deviation_mm)
            limit = min(corner, nominal, last.nominal_mm_s)
        self.moves.append(
            Move(
                start=start,
                end=end,
                unit=unit,
                length_mm=length,
                nominal_mm_s=nominal,
                acceleration_mm_s2=along(unit, settings.acceleration_mm_s2),
                entry_limit_mm_s=limit,
            )
        )
        self.planned = end
        self._stale = self.state == "moving"

    def start(self) -> None:
        """Begin, or go on after a stop; without moves there is nothing to do."""
        if self.moves and self.state != "moving":
            if not self.trace:
                self.trace.append((self._now, self.moves[0].start))
            self._plan(0.0)

    def brake(self) -> None:
        """Slow down to a stop along the path; the moves stay queued."""
        if self.state == "moving":
            _, speed = self._where()
            self.state, self._stale = "braking", False
            self._brake_from(speed)

    def halt(self) -> Vector:
        """Stop dead and forget all moves; returns the way that inertia would still take the axes [mm]."""
        slip = (0.0, 0.0, 0.0)
        if self.moves:
            move = self.moves[0]
            _, speed = self._where()
            way = speed**2 / (2 * move.acceleration_mm_s2)
            slip = (move.unit[0] * way, move.unit[1] * way, move.unit[2] * way)
            self.position = self.position_steps()
            self.trace.append((self._now, self.position))
        self.moves.clear()
        self.state, self._done_mm, self._stale = "still", 0.0, False
        self.planned = self.position
        return slip

    def place(self, position: Steps) -> None:
        """Say where the axes are, with nothing queued [steps]."""
        self.position = self.planned = position

    def advance(self, now_s: float) -> None:
        """Let time pass until [s]."""
        while (end := self.next_s()) <= now_s:
            self._now = end
            self._finish_piece()
        self._now = max(self._now, now_s)

    def next_s(self) -> float:
        """Return when the present move, or its braking, ends [s]; infinite if nothing moves."""
        if self.state == "still":
            return inf
        if self._stale:
            self._plan(self._where()[1])
        assert self._profile is not None
        return self._since + self._profile.duration_s

    def position_steps(self) -> Steps:
        """Return where the axes are, as the controller counts [steps]."""
        if not self.moves:
            return self.position
        move = self.moves[0]
        part = min(1.0, self._where()[0] / move.length_mm)
        x, y, z = (a + round(part * (b - a)) for a, b in zip(move.start, move.end, strict=True))
        return (x, y, z)

    def speed_mm_s(self) -> float:
        """Return the speed along the path [mm/s]."""
        return self._where()[1]

    def _where(self) -> tuple[float, float]:
        """Return how far the first move is done [mm] and the speed [mm/s]."""
        if self.state == "still" or self._profile is None:
            return self._done_mm, 0.0
        distance, speed = self._profile.at(self._now - self._since)
        return self._done_mm + distance, speed

    def _plan(self, speed: float) -> None:
        """Plan all queued moves anew from where the axes are, at a speed [mm/s]."""
        if self.state != "still":
            self._done_mm = self._where()[0]
        moves = self.moves
        lengths = [move.length_mm for move in moves]
        lengths[0] = max(0.0, lengths[0] - self._done_mm)
        limits = [move.entry_limit_mm_s for move in moves]
        speeds = entry_speeds(lengths, limits, [move.acceleration_mm_s2 for move in moves], speed)
        self.state, self._stale, self._exits = "moving", False, deque(speeds[1:])
        self._begin(lengths[0], speed)

    def _begin(self, length: float, entry: float) -> None:
        move = self.moves[0]
        self._since, self._left = self._now, self._exits.popleft()
        self._profile = trapezoid(
            length,
            entry_mm_s=entry,
            exit_mm_s=self._left,
            limit_mm_s=move.nominal_mm_s,
            acceleration_mm_s2=move.acceleration_mm_s2,
        )

    def _brake_from(self, speed: float) -> None:
        move = self.moves[0]
        if self._profile is not None:
            self._done_mm = self._where()[0]
        self._since = self._now
        self._profile, self._left = braking(
            max(0.0, move.length_mm - self._done_mm), entry_mm_s=speed, acceleration_mm_s2=move.acceleration_mm_s2
        )

    def _finish_piece(self) -> None:
        if self.state == "braking" and self._left == 0:
            self._done_mm, self.state, self._profile = self._where()[0], "still", None
            return
        move, speed = self.moves.popleft(), self._left
        self.position, self._done_mm, self._profile = move.end, 0.0, None
        self.trace.append((self._now, move.end))
        if not self.moves:
            self.state = "still"
            self.dry_s.append(self._now)
        elif self.state == "moving":
            self._begin(self.moves[0].length_mm, speed)
        else:
            self._brake_from(speed)
