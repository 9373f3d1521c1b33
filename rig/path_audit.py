"""Positions that a stage reports, compared with where it was told to go."""

from itertools import pairwise
from math import dist, sqrt

from planner.errors import RigError
from rig.dialects.grbl_settings import Axes

REPORT_MM = 0.001
"""Positions are reported with three decimals and sent with four [mm]."""
REPORT_MM_S = 0.02
"""Speeds are reported in whole mm/min [mm/s]."""
NEAR = 6
"""Points ahead whose moves may be under way where two or more of them meet."""
WINDOW = 2000
"""Points ahead that are looked at: many more than a stage can pass between two reports."""


class PathAudit:
    """Path of a stage in machine positions; what was passed is forgotten."""

    def __init__(self, *, step_mm: Axes) -> None:
        """Audit a stage with such steps [mm]."""
        self._half = tuple(step / 2 for step in step_mm)
        # On the way the controller rounds each axis to a step, and to another one between two of the longest axis.
        self._tolerance = 1.5 * sqrt(sum(step * step for step in step_mm)) + REPORT_MM
        self._path: list[Axes] = [(0.0, 0.0, 0.0)]
        self._speeds: list[float] = []

    @property
    def end_mm(self) -> Axes:
        """Where the path ends so far [mm]."""
        return self._path[-1]

    def begin(self, position_mm: Axes) -> None:
        """Start a path at a position [mm]."""
        self._path, self._speeds = [position_mm], []

    def extend(self, position_mm: Axes, speed_mm_s: float) -> None:
        """Add a straight move to a position [mm] at a speed [mm/s]."""
        self._path.append(position_mm)
        self._speeds.append(speed_mm_s)

    def on_path(self, position_mm: Axes, speed_mm_s: float = 0.0) -> None:
        """Compare a position [mm] and a speed [mm/s] on the way with the rest of the path.

        Slower than planned is legal, since the stage speeds up and slows down.

        Raises:
            RigError: if it is not on the path, or faster than planned there.
        """
        nearest = dist(self._path[0], position_mm)
        for passed, (start, end) in enumerate(pairwise(self._path[:WINDOW])):
            nearest = min(nearest, _distance(position_mm, start, end))
            if nearest <= self._tolerance:
                del self._path[:passed], self._speeds[:passed]
                self._not_faster(position_mm, speed_mm_s)
                return
        if nearest > self._tolerance:
            raise RigError(
                f"The stage was seen at {_shown(position_mm)}, {nearest:.3f} mm off its path (allowed are"
                f" {self._tolerance:.3f}): check the cable for noise, then home."
            )

    def at_end(self, position_mm: Axes) -> None:
        """Compare a position after all moves with the end of the path, to half a step [mm].

        Raises:
            RigError: if it is not there.
        """
        planned = self._path[-1]
        if any(abs(a - b) > half + REPORT_MM for a, b, half in zip(position_mm, planned, self._half, strict=True)):
            raise RigError(
                f"The stage ended at {_shown(position_mm)} and should be at {_shown(planned)} (allowed is half a step):"
                " check the cable for noise, then home."
            )
        self._path, self._speeds = [planned], []

    def _not_faster(self, position_mm: Axes, speed_mm_s: float) -> None:
        near = zip(pairwise(self._path[:NEAR]), self._speeds, strict=False)
        allowed = [speed for move, speed in near if _distance(position_mm, *move) <= self._tolerance]
        if speed_mm_s > 1.02 * max(allowed) + REPORT_MM_S:
            raise RigError(
                f"The stage moved at {speed_mm_s:g} mm/s where {max(allowed):g} were told: check the cable for noise,"
                " then home."
            )


def _distance(point: Axes, start: Axes, end: Axes) -> float:
    """Return how far a point is from a straight move [mm]."""
    way = [b - a for a, b in zip(start, end, strict=True)]
    square = sum(part * part for part in way)
    along = sum((c - a) * part for c, a, part in zip(point, start, way, strict=True)) / square if square else 0.0
    part = min(1.0, max(0.0, along))
    return dist(point, [a + part * step for a, step in zip(start, way, strict=True)])


def _shown(position: Axes) -> str:
    return "({:.3f}, {:.3f}, {:.3f}) mm of the machine".format(*position)
