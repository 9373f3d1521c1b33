"""Flattening: from points on the target surface to points on the flat film (paper, section 2.3, Step 2)."""

from planner.flattening.distortion import Distortion, distortion
from planner.flattening.flatten import flatten
from planner.flattening.flattening import Flattening
from planner.flattening.mapping import Located, locate, map_directions, map_points
from planner.flattening.outline import film_outline

__all__ = [
    "Distortion",
    "Flattening",
    "Located",
    "distortion",
    "film_outline",
    "flatten",
    "locate",
    "map_directions",
    "map_points",
]
