"""What every stage shares whose positions are audited: its verbs, its frames and its reach."""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from math import dist

from planner.errors import RigError
from planner.program import Pass
from planner.program.machine import Stage as StageLimits
from planner.program.timing import move_s
from rig.dialects.grbl_settings import Axes
from rig.path_audit import PathAudit

Move = tuple[Axes, float]
"""Where to, in the film frame [mm], and how fast [mm/s]."""


class AuditedStage(ABC):
    """Stage that knows where it was told to go, and compares with that where it is."""

    def __init__(
        self,
        *,
        limits: StageLimits,
        step_mm: Axes,
        origin_mm: Axes,
        reach_mm: tuple[tuple[float, float], ...],
        max_speed_mm_s: Axes,
        acceleration_mm_s2: Axes,
    ) -> None:
        """Start with the film's centre at a machine position [mm], and what each axis reaches in the machine [mm]."""
        self._limits = limits
        self._step = step_mm
        self._origin = origin_mm
        self._reach = reach_mm
        self._max_speed, self._acceleration = max_speed_mm_s, min(acceleration_mm_s2)
        self._expected_s = 0.0
        self._at: Axes = (0.0, 0.0, 0.0)
        self._audit = PathAudit(step_mm=step_mm)

    def lift(self) -> None:
        """Start raising the post to the clearance height."""
        self._go([((self._at[0], self._at[1], self._limits.lift_mm), self._limits.lift_speed_mm_s)])

    def move_to(self, x_mm: float, y_mm: float) -> None:
        """Start moving the lifted post over a point [mm].

        Raises:
            RigError: if the post is not lifted, or the point is out of reach.
        """
        if self._at[2] < self._limits.lift_mm - self._step[2]:
            raise RigError(
                f"The post is {self._at[2]:g} mm above the film and needs {self._limits.lift_mm:g} mm to move over it:"
                " lift it."
            )
        self._go([((x_mm, y_mm, self._at[2]), self._limits.travel_speed_mm_s)])

    def scratch(self, stroke: Pass) -> None:
        """Lower the post at the first point of a pass and start moving along it at its speeds.

        `wait_idle` keeps the controller fed, so call it soon.

        Raises:
            RigError: if the post is not over the first point, or a point is out of reach.
        """
        first = stroke.points_mm[0]
        if dist(first, self._at[:2]) > max(self._step):
            raise RigError(
                f"The post is over ({self._at[0]:g}, {self._at[1]:g}) and the pass starts at"
                f" ({first[0]:g}, {first[1]:g}) mm: move there first."
            )
        lowered = ((*first, 0.0), self._limits.lift_speed_mm_s)
        along = zip(stroke.points_mm[1:], stroke.speed_mm_s, strict=True)
        self._go([lowered, *(((*point, 0.0), speed) for point, speed in along)])

    def lower(self, height_mm: float) -> None:
        """Start lowering the lifted post straight down to a height over the film's surface [mm].

        Raises:
            RigError: if that is out of reach.
        """
        self._go([((self._at[0], self._at[1], height_mm), self._limits.lift_speed_mm_s)])

    @abstractmethod
    def _go(self, moves: list[Move]) -> None:
        """Begin to move along straight lines, after `_check_reach` of each."""

    @abstractmethod
    def stop(self) -> None:
        """Stop moving and drop all moves."""

    def _expect(self, start: Axes, target: Axes, speed_mm_s: float) -> None:
        """Let the audit know of a move in the film frame [mm], and add the time that it should take at most."""
        self._audit.extend(self._machine(target), speed_mm_s)
        moved = [most for a, b, most in zip(start, target, self._max_speed, strict=True) if a != b]
        self._expected_s += move_s(dist(start, target), min([speed_mm_s, *moved]), self._acceleration)

    @contextmanager
    def _stopped_on_failure(self) -> Iterator[None]:
        try:
            yield
        except RigError:
            with suppress(RigError):  # the first failure is the one to tell
                self.stop()
            raise

    def _check_reach(self, target: Axes) -> None:
        for name, at, (low, high) in zip("xyz", self._machine(target), self._reach, strict=True):
            if not low <= at <= high:
                raise RigError(
                    f"The move to ({target[0]:g}, {target[1]:g}, {target[2]:g}) mm needs the stage's {name} at {at:g}"
                    f" mm; allowed is {low:g} to {high:g}: move the film or make it smaller."
                )

    def _machine(self, film: Axes) -> Axes:
        x, y, z = (a + b for a, b in zip(film, self._origin, strict=True))
        return (x, y, z)

    def _film(self, machine: Axes) -> Axes:
        x, y, z = (a - b for a, b in zip(machine, self._origin, strict=True))
        return (x, y, z)
