"""Picture of the target surface."""

from pathlib import Path

import numpy as np

from planner.target import Target, surface_mesh
from scenes.pictures.relief import draw_relief

_EDGE_SHARE = 1 / 120
"""Edge of the drawn triangles over the outline's longer side: finer than the eye at this size."""


def draw_target(path: str | Path, target: Target) -> None:
    """Draw a target into a PNG."""
    vertices, triangles = drawn_target(target)
    draw_relief(path, vertices, triangles, title=f"Target: {target.name}")


def drawn_target(target: Target) -> tuple[np.ndarray, np.ndarray]:
    """Return a target's surface as pictures show it: vertices [mm], shape [n, 3], and triangles, shape [m, 3]."""
    return surface_mesh(target, max(target.size_mm) * _EDGE_SHARE)
