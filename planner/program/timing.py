"""How long a machine needs for the passes of a layer, and how long each pass waits for its cure."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import dist, sqrt
from typing import Any

from planner.program.machine import Machine, Stage
from planner.program.operations import Pass
from planner.program.program import Program


@dataclass(frozen=True, kw_only=True)
class LayerTime:
    """Time to scratch one layer, from the first touch of the post to the lamp."""

    index: int
    """Layer, 0 at the bottom."""
    motion_s: float
    """Post on the film [s]."""
    travel_s: float
    """Lifting, moving over to the next pass, lowering [s]."""
    load_s: float
    """Waiting for the pump to change the load between passes [s]."""
    pass_to_cure_s: tuple[float, ...]
    """For each pass, the time from its middle to the start of the cure [s]: what fading works on."""

    @property
    def total_s(self) -> float:
        """Time to scratch the whole layer [s]."""
        return self.motion_s + self.travel_s + self.load_s


def layer_times(program: Program, machine: Machine) -> tuple[LayerTime, ...]:
    """Calculate the scratching time of every layer, bottom first; a polydomain layer takes none.

    The post waits, lifted, above the first pass of each layer; the chamber is empty before the first layer
    and keeps its load from layer to layer.
    """
    load, times = 0.0, []
    for layer in program.layers:
        times.append(scratch_time(layer.passes, machine, index=layer.index, load_g=load))
        load = layer.passes[-1].load_g[-1] if layer.passes else load
    return tuple(times)


def layer_figures(program: Program, times: Sequence[LayerTime]) -> list[dict[str, Any]]:
    """Collect what is scratched into each layer and how long it takes, as plain values with their units."""
    return [
        {
            "index": layer.index,
            "thickness_mm": layer.thickness_mm,
            "passes": len(layer.passes),
            "length_mm": sum(stroke.length_mm for stroke in layer.passes),
            "motion_s": time.motion_s,
            "travel_s": time.travel_s,
            "load_s": time.load_s,
            "total_s": time.total_s,
        }
        for layer, time in zip(program.layers, times, strict=True)
    ]


def scratch_time(passes: Sequence[Pass], machine: Machine, *, index: int = 0, load_g: float = 0.0) -> LayerTime:
    """Calculate the time for passes in order, starting with a load in the chamber [g].

    Moves have trapezoidal speed profiles. Load changes wait with the post lifted: a load that is still
    changing would scratch with the wrong strength.
    """
    stage = machine.stage
    clock, motion, travel, pumping, middles = 0.0, 0.0, 0.0, 0.0, []
    lift = move_s(stage.lift_mm, stage.lift_speed_mm_s, stage.acceleration_mm_s2)
    previous: Pass | None = None
    for stroke in passes:
        if previous is not None:
            over = dist(previous.points_mm[-1], stroke.points_mm[0])
            hop = 2 * lift + move_s(over, stage.travel_speed_mm_s, stage.acceleration_mm_s2)
            travel, clock = travel + hop, clock + hop
        wait = machine.pump.change_s(stroke.load_g[0] - load_g)
        run = pass_s(stroke, stage)
        middles.append(clock + wait + run / 2)
        pumping, motion, clock = pumping + wait, motion + run, clock + wait + run
        load_g, previous = stroke.load_g[-1], stroke
    return LayerTime(
        index=index,
        motion_s=motion,
        travel_s=travel,
        load_s=pumping,
        pass_to_cure_s=tuple(clock - middle for middle in middles),
    )


def pass_s(stroke: Pass, stage: Stage) -> float:
    """Calculate the time of one pass from rest to rest [s].

    Speed changes happen within the faster segment: going from v to w > v then costs (w - v)^2 / (2 a w)
    more than if the speed could jump.
    """
    ramps = pairwise((0.0, *stroke.speed_mm_s, 0.0))
    lost = sum((v - w) ** 2 / max(v, w) for v, w in ramps) / (2 * stage.acceleration_mm_s2)
    return stroke.scratch_s + lost


def move_s(distance_mm: float, speed_mm_s: float, acceleration_mm_s2: float) -> float:
    """Calculate the time of a straight move from rest to rest with a trapezoidal speed profile [s]."""
    if distance_mm * acceleration_mm_s2 < speed_mm_s**2:
        return 2 * sqrt(distance_mm / acceleration_mm_s2)
    return distance_mm / speed_mm_s + speed_mm_s / acceleration_mm_s2
