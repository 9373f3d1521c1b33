"""How to split a layer that takes too long into pieces that are deposited, scratched and cured one by one."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil, inf

from planner.program.machine import Machine
from planner.program.operations import Pass
from planner.program.timing import scratch_time


@dataclass(frozen=True, kw_only=True)
class Segment:
    """One cell of the grid that a layer is split into."""

    x_mm: tuple[float, float]
    """Left and right border [mm]; infinite at the film's edge."""
    y_mm: tuple[float, float]
    """Lower and upper border [mm]; infinite at the film's edge."""
    passes: tuple[int, ...]
    """Indices of the layer's passes whose middle lies in this cell, in their order."""
    scratch_s: float
    """Time to scratch them [s]."""


def split_layer(passes: Sequence[Pass], machine: Machine) -> tuple[Segment, ...]:
    """Split passes into the fewest cells that each fit the machine's budget for one layer.

    Columns, each cut into rows, at borders that share the scratching time evenly. A pass belongs to the cell
    of its middle; passes are not cut. A layer that fits is one cell. Where a single pass is over the budget
    no split helps, and the finest split is returned.
    """
    budget = machine.layer.budget_s
    total = scratch_time(passes, machine).total_s
    cells = max(1, ceil(total / budget))
    middles = [stroke.points_mm[len(stroke.points_mm) // 2] for stroke in passes]
    spans = [max(values) - min(values) for values in zip(*middles, strict=True)] or [0.0, 0.0]
    while True:
        columns = _columns(cells, spans[0], spans[1])
        segments = _grid(passes, middles, columns, ceil(cells / columns), machine)
        if cells >= len(passes) or all(segment.scratch_s <= budget for segment in segments):
            return segments
        cells += 1


def describe_split(segments: Sequence[Segment]) -> str:
    """Say where the borders are, cell by cell, as `x below 3.1 mm, y above 0.0 mm: 48 min`."""
    words = []
    for segment in segments:
        sides = []
        for name, (low, high) in (("x", segment.x_mm), ("y", segment.y_mm)):
            if low > -inf and high < inf:
                sides.append(f"{name} {low:.1f} to {high:.1f} mm")
            elif high < inf:
                sides.append(f"{name} below {high:.1f} mm")
            elif low > -inf:
                sides.append(f"{name} above {low:.1f} mm")
        words.append(f"{', '.join(sides) or 'all'}: {segment.scratch_s / 60:.0f} min")
    return "; ".join(words)


def _columns(cells: int, width: float, height: float) -> int:
    """Number of columns that makes the cells about square."""
    if width <= 0 or height <= 0:
        return cells if width > height else 1
    return min(cells, max(1, round((cells * width / height) ** 0.5)))


def _grid(
    passes: Sequence[Pass],
    middles: Sequence[tuple[float, float]],
    columns: int,
    rows: int,
    machine: Machine,
) -> tuple[Segment, ...]:
    segments = []
    for x_range, column in _share(range(len(passes)), passes, middles, 0, columns):
        for y_range, members in _share(column, passes, middles, 1, rows):
            time = scratch_time([passes[i] for i in members], machine).total_s
            segments.append(Segment(x_mm=x_range, y_mm=y_range, passes=tuple(members), scratch_s=time))
    return tuple(segments)


def _share(
    members: Sequence[int],
    passes: Sequence[Pass],
    middles: Sequence[tuple[float, float]],
    axis: int,
    parts: int,
) -> list[tuple[tuple[float, float], list[int]]]:
    """Cut along one axis into parts of about equal time on the film."""
    ranked = sorted(members, key=lambda i: middles[i][axis])
    total = sum(passes[i].scratch_s for i in ranked)
    groups: list[list[int]] = [[] for _ in range(parts)]
    done = 0.0
    for i in ranked:
        half = passes[i].scratch_s / 2
        groups[min(parts - 1, int((done + half) / total * parts))].append(i)
        done += 2 * half
    groups = [group for group in groups if group]
    borders = [(middles[a[-1]][axis] + middles[b[0]][axis]) / 2 for a, b in pairwise(groups)]
    edges = [-inf, *borders, inf]
    return [((edges[k], edges[k + 1]), sorted(group)) for k, group in enumerate(groups)]
