"""Bars of the time that each layer takes on the machine, beside what its ink allows."""

from dataclasses import dataclass
from typing import Any

PARTS = (("motion_s", "post on the film"), ("travel_s", "travel"), ("load_s", "changing the load"))


@dataclass(frozen=True, kw_only=True)
class TimeBar:
    """One layer's time."""

    layer: int
    """Counted from 1 at the bottom, as at the bench."""
    passes: int
    length_mm: float
    total_s: float
    parts: tuple[tuple[str, float, float], ...]
    """Each part's name, its time [s] and its width in percent of the scale."""
    over_budget: bool


@dataclass(frozen=True, kw_only=True)
class TimeBars:
    """All layers in one scale."""

    bars: tuple[TimeBar, ...]
    budget_s: float
    budget_percent: float
    """Place of the budget on the scale."""


def time_bars(result: dict[str, Any]) -> TimeBars:
    """Draw up the bars from the content of result.json."""
    budget_s = result["machine"]["budget_s"]
    scale_s = 1.05 * max(budget_s, *(layer["total_s"] for layer in result["layers"]))
    return TimeBars(
        bars=tuple(_bar(layer, budget_s, scale_s) for layer in result["layers"]),
        budget_s=budget_s,
        budget_percent=100 * budget_s / scale_s,
    )


def _bar(layer: dict[str, Any], budget_s: float, scale_s: float) -> TimeBar:
    return TimeBar(
        layer=layer["index"] + 1,
        passes=layer["passes"],
        length_mm=layer["length_mm"],
        total_s=layer["total_s"],
        parts=tuple((name, layer[key], 100 * layer[key] / scale_s) for key, name in PARTS),
        over_budget=layer["total_s"] > budget_s,
    )
