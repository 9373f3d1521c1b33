"""Shapes at the temperatures asked for: how deep they are, whether the film comes back, and by the way it went."""

from dataclasses import replace
from itertools import combinations

import numpy as np

from twin.equilibrium import moved_onto, rigid_distance_mm
from twin.hot_shape import HotShape
from twin.predict import PredictOptions
from twin.temperature import ROOM_C

__all__ = ["back_to_flat_mm", "cooled", "depth_mm", "hysteresis_mm", "level_mm", "rigid_distance_mm"]


def cooled(options: PredictOptions) -> PredictOptions:
    """Return the options with the film cooled to the room's temperature in the end."""
    return replace(options, temperatures_c=(*options.stops_c, ROOM_C))


def level_mm(shape: HotShape, index: int) -> np.ndarray:
    """Return the mid-surface at an accepted temperature, turned level and its lowest point at z = 0 [mm], [n, 3]."""
    flat = shape.film.flat_mm
    level = moved_onto(shape.vertices_mm[index], np.column_stack((flat, np.zeros(len(flat)))))
    return level - (0.0, 0.0, level[:, 2].min())


def depth_mm(shape: HotShape, index: int) -> float:
    """Return how deep the level mid-surface is at an accepted temperature [mm]."""
    return float(level_mm(shape, index)[:, 2].max())


def back_to_flat_mm(shape: HotShape) -> float | None:
    """Return how far a film that was cooled in the end is from the flat one [mm]; None if it was not cooled."""
    if shape.stops[-1].temperature_c > ROOM_C or len(shape.stops) == 1:
        return None
    return rigid_distance_mm(shape.vertices_mm[-1], shape.vertices_mm[0])


def hysteresis_mm(shape: HotShape) -> dict[float, float]:
    """Return the largest distance between shapes at the same stop [mm], by the temperatures [C] passed repeatedly."""
    apart: dict[float, float] = {}
    for a, b in combinations(shape.stops, 2):
        if a.temperature_c == b.temperature_c:
            distance = rigid_distance_mm(shape.vertices_mm[a.index], shape.vertices_mm[b.index])
            apart[a.temperature_c] = max(distance, apart.get(a.temperature_c, 0.0))
    return apart
