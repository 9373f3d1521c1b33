"""What is watched along one pass: whether it was disturbed, and what the post pressed with."""

from itertools import pairwise
from math import dist
from statistics import fmean

from planner.program import Pass
from rig.devices import ForceGauge, PostLoad, Sighting

DOWN_MM = 0.02
"""The post is on the film up to this height [mm]."""
EVEN_G = 0.2
"""Forces that spread less are taken for one [g]."""
SLOW_S, SLOW_SHARE = 0.5, 0.02
"""A pass that takes so much longer than planned was slower everywhere; less is the time of the wire."""


class Stroke:
    """A `Watch` on one pass, that changes the load along it where the Program says so."""

    def __init__(self, planned: Pass, load: PostLoad, gauge: ForceGauge | None) -> None:
        self.held = False
        """Whether it was held up on the way, by a feed hold or a door."""
        self._planned = planned
        self._load = load
        self._gauge = gauge
        self._forces: list[tuple[float, float]] = []
        self._along_mm = [0.0]
        for a, b in pairwise(planned.points_mm):
            self._along_mm.append(self._along_mm[-1] + dist(a, b))
        self._segment = 0
        self._loads_g: list[float] = []
        """Counted at each point that the post has passed."""

    def __call__(self, seen: Sighting) -> None:
        """Take notice of where the stage is."""
        self.held = self.held or seen.held
        if seen.position_mm[2] > DOWN_MM:
            return
        along_mm = self._progress(seen.position_mm[:2])
        if self._gauge is not None:
            self._forces.append((along_mm, self._gauge.force_g()))
        if len(self._planned.load_g) > 1:
            self._change_load()
            self._load.keep_alive()

    def done(self, took_s: float, expected_s: float) -> tuple[Pass, tuple[float, ...] | None]:
        """Return the pass with the loads counted and speeds measured, and the post's own loads where measured."""
        slower = 1.0
        if took_s > expected_s * (1 + SLOW_SHARE) + SLOW_S:
            slower = expected_s / took_s
        speeds = tuple(speed * slower for speed in self._planned.speed_mm_s)
        loads = self._planned.load_g
        if len(loads) > 1:
            counted = self._load.load_g()
            loads = tuple(max(1e-3, value) for value in [*self._loads_g, *[counted] * len(loads)][: len(loads)])
        else:
            loads = (max(1e-3, self._load.load_g()),)
        return self._planned.model_copy(update={"speed_mm_s": speeds, "load_g": loads}), self._post_loads()

    def so_far(self) -> Pass | None:
        """Return the part that was seen done, as planned; None if there was none."""
        count = self._segment + 1
        if count < 2:
            return None
        loads = self._planned.load_g
        return self._planned.model_copy(
            update={
                "points_mm": self._planned.points_mm[:count],
                "speed_mm_s": self._planned.speed_mm_s[: count - 1],
                "load_g": loads if len(loads) == 1 else loads[:count],
            }
        )

    def _progress(self, position_mm: tuple[float, ...]) -> float:
        """Return how far along the pass a position is [mm], never less than before."""
        points = self._planned.points_mm
        while self._segment < len(points) - 2:
            here, after = (_distance(position_mm, *points[k : k + 2]) for k in (self._segment, self._segment + 1))
            if here <= after:
                break
            self._segment += 1
        start = points[self._segment]
        return min(self._along_mm[self._segment] + dist(start, position_mm), self._along_mm[-1])

    def _change_load(self) -> None:
        while len(self._loads_g) <= self._segment:
            self._loads_g.append(self._load.load_g())
            self._load.set_load(self._planned.load_g[len(self._loads_g)])

    def _post_loads(self) -> tuple[float, ...] | None:
        if not self._forces:
            return None
        forces = [force for _, force in self._forces]
        if max(forces) - min(forces) < EVEN_G:
            return (fmean(forces),)
        return tuple(min(self._forces, key=lambda at: abs(at[0] - along))[1] for along in self._along_mm)


def _distance(point: tuple[float, ...], start: tuple[float, ...], end: tuple[float, ...]) -> float:
    way = (end[0] - start[0], end[1] - start[1])
    square = way[0] ** 2 + way[1] ** 2
    along = ((point[0] - start[0]) * way[0] + (point[1] - start[1]) * way[1]) / square if square else 0.0
    along = min(1.0, max(0.0, along))
    return dist(point, (start[0] + along * way[0], start[1] + along * way[1]))
