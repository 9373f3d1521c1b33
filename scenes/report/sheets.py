"""The surfaces of the 3-D view: the film at each temperature, and the target in the same frame and scale."""

from typing import Any

import numpy as np
from scipy.spatial import KDTree

from scenes.pictures.error_map import error_colours
from scenes.pictures.relief import SKIN, VIEW_FROM, Colours, light_from
from scenes.pictures.target import drawn_target
from scenes.report.contents import ReportContents
from scenes.report.packing import pack_indices, pack_numbers
from scenes.report.thinned import thin_out
from twin.score import Scored

SHADES = 17
"""Colours that a colour map is written down with."""


def pack_sheets(contents: ReportContents) -> dict[str, Any]:
    """Collect what the 3-D view shows, as plain values for JSON.

    The film is its mid-surface, moved as the scored shape was moved over its target, at all temperatures alike.
    """
    shape, scored = thin_out(contents.shape), contents.scored
    states = shape.vertices_mm if scored is None else scored.transform.apply(shape.vertices_mm)
    target = None if contents.target is None else drawn_target(contents.target)
    every = states.reshape(-1, 3) if target is None else np.concatenate([states.reshape(-1, 3), target[0]])
    low, high = every.min(axis=0), every.max(axis=0)
    height = Colours(
        values=states[..., 2], label="height [mm]", low=float(low[2]), high=float(high[2]), colour_map="viridis"
    )
    error = None if scored is None else error_colours(_error_mm(scored, shape.top_mm))
    return {
        "temperature_c": shape.temperature_c.tolist(),
        "hottest": shape.hottest,
        "film": {**_surface(states, shape.triangles), "error": None if error is None else _values(error)},
        "target": None if target is None else _surface(*target),
        "low_mm": low.tolist(),
        "high_mm": high.tolist(),
        "scales": {"height": _scale(height), "error": None if error is None else _scale(error)},
        "skin": SKIN,
        "view_from": VIEW_FROM.tolist(),
        "light_from": light_from().tolist(),
    }


def _error_mm(scored: Scored, top_mm: np.ndarray) -> np.ndarray:
    """Return the error of the point that the scanner saw nearest to each vertex of the hot film [mm], shape [n]."""
    nearest = KDTree(scored.vertices_mm).query(scored.transform.apply(top_mm))[1]
    return scored.error_mm[nearest]


def _surface(vertices_mm: np.ndarray, triangles: np.ndarray) -> dict[str, Any]:
    return {"vertices_mm": pack_numbers(vertices_mm), "triangles": pack_indices(triangles)}


def _values(colours: Colours) -> dict[str, Any]:
    return pack_numbers(np.clip(colours.values, colours.low, colours.high))


def _scale(colours: Colours) -> dict[str, Any]:
    """Write a colour map down as evenly spaced colours."""
    import matplotlib
    from matplotlib.colors import to_hex

    colour_map = matplotlib.colormaps[colours.colour_map]
    return {
        "label": colours.label,
        "low": colours.low,
        "high": colours.high,
        "colours": [to_hex(colour_map(place)) for place in np.linspace(0.0, 1.0, SHADES)],
    }
