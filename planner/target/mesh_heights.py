"""From a triangle mesh to the heights of its top surface."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from planner.errors import InputError
from planner.target.rasterise import Sheets, rasterise

GRID_MM = 0.1
"""Grid spacing for surfaces from meshes, the sampling of the paper's Step 1 [mm]."""
MOST_COLUMNS = 1000
"""Most grid columns or rows; larger surfaces get a coarser grid."""
FEWEST_COLUMNS = 64
"""Fewest columns and rows; smaller surfaces get a finer grid."""
SHEET_GAP_SHARE = 0.005
"""Sheets closer than this share of the size are one: a shell's own thickness is no overhang."""
OPEN_SHARE = 0.25
"""A mesh whose open edges are shorter than this share of its outline counts as closed: scans have small holes."""
HIDDEN_SHARE_OPEN = 0.10
"""Largest share of an open sheet that may hide other parts; noses and brows of scans stay far below it."""
HIDDEN_SHARE_CLOSED = 0.30
"""The same for a solid, whose top is clear anyhow: bodies stuck into each other hide parts without harm."""
NOTED_SHARE = 0.001
"""Share of hidden sheets below which nothing is said: rounding on steep walls."""


@dataclass(frozen=True, kw_only=True, eq=False)
class GridHeights:
    """Heights over a grid, as a reader hands them to the constructor of targets."""

    x_mm: np.ndarray
    """Grid columns [mm], shape [nx]."""
    y_mm: np.ndarray
    """Grid rows [mm], shape [ny]."""
    z_mm: np.ndarray
    """Heights [mm], NaN outside, shape [ny, nx]."""
    notes: tuple[str, ...] = ()
    """What the user should know about how the surface was read."""


def even_grid(low_mm: np.ndarray, high_mm: np.ndarray, spacing_mm: float) -> tuple[np.ndarray, np.ndarray]:
    """Lay grid columns and rows over a box, both ends included, at most MOST_COLUMNS of each.

    The spacing is adapted to the box, in x and y by a fraction of a cell, so that straight edges lie on nodes.
    """
    extent = (high_mm - low_mm)[:2]
    spacing = max(min(spacing_mm, float(extent.min()) / FEWEST_COLUMNS), float(extent.max()) / MOST_COLUMNS)
    cells = np.maximum(np.round(extent / spacing).astype(int), FEWEST_COLUMNS)
    return (
        np.linspace(low_mm[0], high_mm[0], cells[0] + 1),
        np.linspace(low_mm[1], high_mm[1], cells[1] + 1),
    )


def mesh_heights(vertices_mm: np.ndarray, triangles: np.ndarray, *, name: str) -> GridHeights:
    """Sample the top surface of a mesh on a grid.

    Args:
        vertices_mm: Vertices [mm], z up, shape [n, 3].
        triangles: Vertex indices, shape [m, 3].
        name: Named in messages.

    Raises:
        InputError: Sheets hide each other, or more than two triangles meet at edges of the top surface.
    """
    low, high = vertices_mm.min(axis=0), vertices_mm.max(axis=0)
    x, y = even_grid(low, high, GRID_MM)
    gap = SHEET_GAP_SHARE * float((high - low)[:2].max())
    sheets = rasterise(vertices_mm, triangles, x, y, gap_mm=gap)
    edges, uses = _edges(triangles, len(vertices_mm))

    problems, notes = [], []
    for message, fatal in (
        _hidden_sheets(vertices_mm, edges[uses == 1], sheets, x, y, name),
        _crowded_edges(vertices_mm, edges[uses > 2], sheets, x, y, name),
    ):
        if message:
            (problems if fatal else notes).append(message)
    if problems:
        raise InputError(problems)
    return GridHeights(x_mm=x, y_mm=y, z_mm=sheets.top_mm, notes=tuple(notes))


def _edges(triangles: np.ndarray, vertex_count: int) -> tuple[np.ndarray, np.ndarray]:
    """Undirected edges, shape [k, 2], and how many triangles use each, shape [k]."""
    ends = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    keys, uses = np.unique(ends[:, 0] * vertex_count + ends[:, 1], return_counts=True)
    return np.column_stack(np.divmod(keys, vertex_count)), uses


def _hidden_sheets(
    vertices: np.ndarray, open_edges: np.ndarray, sheets: Sheets, x: np.ndarray, y: np.ndarray, name: str
) -> tuple[str, bool]:
    """Measure how much of the top surface hides other sheets; a closed solid may have its underside."""
    extent = np.ptp(vertices[:, :2], axis=0)
    open_length = np.linalg.norm(vertices[open_edges[:, 0]] - vertices[open_edges[:, 1]], axis=1).sum()
    closed = open_length < OPEN_SHARE * 2.0 * extent.sum()
    hidden = sheets.count > (2 if closed else 1)
    share = hidden.sum() / max(1, (sheets.count > 0).sum())
    if share < NOTED_SHARE:
        return "", False
    rows, columns = np.nonzero(hidden)
    place = f"around x = {np.median(x[columns]):.4g}, y = {np.median(y[rows]):.4g} mm"
    limit = HIDDEN_SHARE_CLOSED if closed else HIDDEN_SHARE_OPEN
    if share < limit:
        return (
            f"{share:.1%} of the top surface overhangs, {place}; what lies under it was cut to steep walls.",
            False,
        )
    kind = "a closed solid" if closed else "an open sheet"
    return (
        f"{name}: the mesh, {kind}, overlaps itself along z: {share:.0%} of its top surface hides other parts, "
        f"{place}; at most {limit:.0%} may: turn it (--up), or keep only the part to be reproduced.",
        True,
    )


def _crowded_edges(
    vertices: np.ndarray, edges: np.ndarray, sheets: Sheets, x: np.ndarray, y: np.ndarray, name: str
) -> tuple[str, bool]:
    """Judge edges where more than two triangles meet: fatal on the top surface, harmless below it."""
    if not len(edges):
        return "", False
    middles = vertices[edges].mean(axis=1)
    columns = np.clip(np.round((middles[:, 0] - x[0]) / (x[1] - x[0])).astype(int), 0, len(x) - 1)
    rows = np.clip(np.round((middles[:, 1] - y[0]) / (y[1] - y[0])).astype(int), 0, len(y) - 1)
    around = ndimage.minimum_filter(np.nan_to_num(sheets.top_mm, nan=-np.inf), size=3)
    visible = middles[:, 2] >= around[rows, columns] - 1e-6
    if not visible.any():
        return (
            f"At {len(edges)} edges below the top surface more than two triangles meet; they were ignored.",
            False,
        )
    place = ", ".join(f"{value:.4g}" for value in middles[np.argmax(visible)])
    return (
        f"{name}: the mesh is not a surface: at {visible.sum()} edges of its top more than two triangles meet, "
        f"the first at ({place}) mm; allowed are two: remove inner walls and doubled faces, for example with "
        "MeshLab's 'Repair non Manifold Edges'.",
        True,
    )
