"""From smooth fields to passes: lines, a load for each, and the order in which they are scratched."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from planner.calibration import Calibration, radius_for_contraction
from planner.program import Machine, Pass, scratch_time
from planner.toolpaths import load_levels, order_passes
from planner.toolpaths.dense import MeshField, Tiling, dense_lines, tiling

LEAST_SHARE = 0.5
"""Of the least contraction that can be scratched: where less is wanted nothing is scratched, where more, the least."""


BUDGET_SHARE = 0.93
"""Of the time for a layer: the speeds change a little afterwards."""
PRICES = np.geomspace(1e-6, 1e-2, 25)
"""Of time [1/s x mm], tried in turn."""
DIGITS = 4


@dataclass(frozen=True, kw_only=True, eq=False)
class TracedLayer:
    """The passes of one layer, in scratching order, and how they tile what was wanted."""

    passes: tuple[Pass, ...]
    tiling: Tiling


def contraction_range(calibration: Calibration) -> tuple[float, float]:
    """Return the least and the largest contraction that can be scratched."""
    limits = calibration.record.limits
    return (
        float(calibration.contraction(limits.load_g_min, limits.speed_mm_s_max)),
        float(calibration.contraction(limits.load_g_max, limits.speed_mm_s_min)),
    )


def trace_layer(
    flat_mm: np.ndarray,
    triangles: np.ndarray,
    q: np.ndarray,
    calibration: Calibration,
    *,
    machine: Machine,
    index: int,
    layers: int,
    line_width_mm: float,
    seed: int,
) -> TracedLayer:
    """Tile a layer's field with passes.

    Args:
        flat_mm: vertices of the flat film [mm], shape [n, 2].
        triangles: vertex indices, shape [m, 3].
        q: alignment vectors at the vertices, shape [n, 2].
        calibration: load and speed for a contraction.
        machine: its budget of time for a layer.
        index: the layer, 0 at the bottom.
        layers: number of layers: the lower half bends the film convex, the upper half concave.
        line_width_mm: width of a scratched line [mm].
        seed: of the lines.
    """
    least, largest = contraction_range(calibration)
    field = MeshField(points_mm=flat_mm, triangles=triangles, q=q)
    lines = dense_lines(field, line_width_mm=line_width_mm, least=LEAST_SHARE * least, seed=seed)
    figures = tiling(lines, field, line_width_mm=line_width_mm, least=LEAST_SHARE * least)
    strength = [np.linalg.norm(field.at(0.5 * (line[1:] + line[:-1])).q, axis=1) for line in lines]
    wanted = [np.clip(own, least, largest) for own in strength]
    side = "convex" if 2 * index < layers else "concave"
    return TracedLayer(passes=_within_budget(lines, wanted, calibration, machine, side), tiling=figures)


def _within_budget(
    lines: Sequence[np.ndarray],
    wanted: Sequence[np.ndarray],
    calibration: Calibration,
    machine: Machine,
    side: Literal["convex", "concave"],
) -> tuple[Pass, ...]:
    """Choose a load for each line and speeds along it, so that the layer fits the machine's budget, and order them.

    A heavier load is faster for the same contraction but cannot give small ones. Each line takes the load with the
    least sum of squared error and time, the time weighed by as little as makes the layer fit.
    """
    if not lines:
        return ()
    loads = load_levels(calibration)
    length = [np.linalg.norm(np.diff(line, axis=0), axis=1) for line in lines]
    owner = np.repeat(np.arange(len(lines)), [len(own) for own in length])
    joined, e = np.concatenate(length), np.concatenate(wanted)
    radius = strip_radius_mm(e, calibration)
    speeds = np.array([calibration.settings_for(radius, load).speed_mm_s for load in loads])
    given = np.array([calibration.contraction(load, own) for load, own in zip(loads, speeds, strict=True)])
    error = np.array([np.bincount(owner, joined * (own - e) ** 2) for own in given])
    spent = np.array([np.bincount(owner, joined / own) for own in speeds])

    def levels(price: float) -> np.ndarray:
        return np.argmin(error + price * spent, axis=0)

    def passes(level: np.ndarray) -> tuple[Pass, ...]:
        speed = np.round(speeds[level[owner], np.arange(len(owner))], DIGITS)
        splits = np.cumsum([len(own) for own in length])[:-1]
        return order_passes(
            [
                Pass(
                    points_mm=tuple(map(tuple, np.round(line, DIGITS).tolist())),
                    speed_mm_s=tuple(own.tolist()),
                    load_g=(float(loads[number]),),
                    side=side,
                )
                for line, own, number in zip(lines, np.split(speed, splits), level, strict=True)
            ]
        )

    def moving_s(level: np.ndarray) -> float:
        return float(spent[level, np.arange(len(level))].sum())

    best = levels(0.0)
    made = passes(best)
    # lifting, travel and pumping hardly depend on which loads are chosen
    total = scratch_time(made, machine).total_s
    excess = total - BUDGET_SHARE * machine.layer.budget_s
    if excess <= 0.0:
        return made
    dearer = (levels(price) for price in PRICES)
    return passes(next((own for own in dearer if moving_s(own) <= moving_s(best) - excess), levels(PRICES[-1])))


def strip_radius_mm(contraction: np.ndarray, calibration: Calibration) -> np.ndarray:
    """Return the radius to which a contraction bends the calibration strip [mm]."""
    strip = calibration.record.strip
    return radius_for_contraction(contraction, strip.layer_thickness_mm, strip.aligned_layers, strip.width_mm)


def pass_contraction(passes: Sequence[Pass], calibration: Calibration) -> np.ndarray:
    """Return the contraction of each segment of passes with one load each, all joined."""
    parts = [calibration.contraction(stroke.load_g[0], np.array(stroke.speed_mm_s)) for stroke in passes]
    return np.concatenate(parts) if parts else np.empty(0)


def pass_bounds(passes: Sequence[Pass], calibration: Calibration) -> tuple[np.ndarray, np.ndarray]:
    """Return least and largest contraction of each segment that its pass's load reaches, all joined."""
    limits = calibration.record.limits
    count = np.array([len(stroke.speed_mm_s) for stroke in passes], dtype=int)
    load = np.repeat([stroke.load_g[0] for stroke in passes], count)
    return calibration.contraction(load, limits.speed_mm_s_max), calibration.contraction(load, limits.speed_mm_s_min)


def with_contraction(passes: Sequence[Pass], contraction: np.ndarray, calibration: Calibration) -> tuple[Pass, ...]:
    """Return passes whose speeds give each segment a contraction, as near as its load allows."""
    limits = calibration.record.limits
    count = np.array([len(stroke.speed_mm_s) for stroke in passes], dtype=int)
    load = np.repeat([stroke.load_g[0] for stroke in passes], count)
    speed = calibration.settings_for(strip_radius_mm(contraction, calibration), load).speed_mm_s
    speed = np.clip(np.round(speed, DIGITS), limits.speed_mm_s_min, limits.speed_mm_s_max)
    return tuple(
        stroke.model_copy(update={"speed_mm_s": tuple(own.tolist())})
        for stroke, own in zip(passes, np.split(speed, np.cumsum(count)[:-1]), strict=True)
    )
