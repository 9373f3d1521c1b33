"""Picture of the target surface."""

from pathlib import Path

from planner.target import Target, surface_mesh
from scenes.pictures.relief import draw_relief

_EDGE_SHARE = 1 / 120
"""Edge of the drawn triangles over the outline's longer side: finer than the eye at this size."""


def draw_target(path: str | Path, target: Target) -> None:
    """Draw a target into a PNG."""
    vertices, triangles = surface_mesh(target, max(target.size_mm) * _EDGE_SHARE)
    draw_relief(path, vertices, triangles, title=f"Target: {target.name}")
