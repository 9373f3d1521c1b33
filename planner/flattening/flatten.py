"""Flatten a target: one entry for both methods."""

from typing import Literal

import numpy as np

from planner.errors import InputError
from planner.flattening.arap import arap_film_positions
from planner.flattening.blocks import block_film_positions
from planner.flattening.flattening import Flattening
from planner.flattening.orientation import place_upright, signed_double_areas
from planner.target import Surface, Target, surface_mesh

NEXT_STEP = {
    "arap": "Smooth the steepest walls of the target, or choose another edge_mm.",
    "grid": "Use method 'arap', which cannot fold, or larger blocks.",
}
"""What to do when a method folds the film; its keys are the methods."""


def flatten(
    target: Target,
    *,
    method: Literal["arap", "grid"] = "arap",
    edge_mm: float = 0.8,
    block_mm: float = 3.0,
) -> Flattening:
    """Lay the target's surface flat.

    Args:
        target: the surface.
        method: `arap` keeps every triangle as rigid as possible (libigl); `grid` is the paper's algorithm of tilted
            blocks (section 2.3, Step 2). docs/decisions/0001-flattening.md compares them.
        edge_mm: edge length of the surface mesh [mm].
        block_mm: side of the blocks of `grid` [mm]; the paper does not state its own; on six of nine
            scanned surfaces 3 mm keeps 95 % of the lengths better than 2 mm.

    Raises:
        InputError: for an unknown method or length, or when `grid` folds the film over itself.
    """
    _check(method, edge_mm, block_mm)
    vertices, triangles = surface_mesh(target, edge_mm)
    if method == "arap":
        film, notes = arap_film_positions(vertices, triangles)
    else:
        low, high = vertices[:, :2].min(axis=0), vertices[:, :2].max(axis=0)
        film = block_film_positions(Surface(target), (low, high), vertices[:, :2], block_mm=block_mm)
        notes = ()
    folded = int(np.count_nonzero(signed_double_areas(film, triangles) <= 0))
    if folded:
        raise InputError(
            f"Flattening '{target.name}' by method '{method}' folds {folded} of {len(triangles)} triangles over; "
            f"a film must lie flat without folds. {NEXT_STEP[method]}"
        )
    return Flattening(
        method=method,
        vertices_mm=vertices,
        triangles=triangles,
        film_mm=place_upright(film, vertices[:, :2]),
        notes=notes,
    )


def _check(method: str, edge_mm: float, block_mm: float) -> None:
    problems = []
    if method not in NEXT_STEP:
        problems.append(f"Flattening method '{method}' is unknown; choose one of {', '.join(NEXT_STEP)}.")
    for name, value in (("edge_mm", edge_mm), ("block_mm", block_mm)):
        if not (np.isfinite(value) and value > 0):
            problems.append(f"Flattening's {name} is {value}; it must be a positive length in mm, such as 1.")
    if problems:
        raise InputError(problems)
