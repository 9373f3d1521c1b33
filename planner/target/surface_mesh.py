"""Triangle mesh of a target's top surface."""

import numpy as np

from planner.target.planar_mesh import mesh_outline
from planner.target.surface import Surface
from planner.target.target import Target


def surface_mesh(target: Target, edge_mm: float) -> tuple[np.ndarray, np.ndarray]:
    """Triangulate the top surface; the triangles are regular seen from above.

    Args:
        target: The surface.
        edge_mm: Edge length seen from above [mm]; on slopes the edges are longer.

    Returns:
        Vertices [mm], shape [n, 3], those of the outline first, and triangles, counter-clockwise seen from
        above, shape [m, 3].

    Raises:
        InputError: The outline is too narrow for the edge length.
    """
    points, triangles = mesh_outline(target.outline_mm, edge_mm)
    heights = Surface(target).extended_height(points)
    return np.column_stack((points, heights)), triangles
