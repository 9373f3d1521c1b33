"""Picture of the distance between the hot shape and its target."""

from pathlib import Path

import numpy as np

from scenes.pictures.relief import Colours, draw_relief


def draw_error_map(
    path: str | Path,
    vertices_mm: np.ndarray,
    triangles: np.ndarray,
    error_mm: np.ndarray,
    *,
    rms_mm: float,
    hausdorff_mm: float,
) -> None:
    """Draw the registered shape, coloured by its distance from the target, into a PNG.

    Args:
        path: File to write.
        vertices_mm: Registered vertices [mm], shape [n, 3], float.
        triangles: Vertex indices, shape [m, 3], int.
        error_mm: Distance of each vertex from the target [mm], positive above it, shape [n], float.
        rms_mm: Root mean square distance [mm], for the caption.
        hausdorff_mm: Largest distance [mm], for the caption.
    """
    draw_relief(
        path,
        vertices_mm,
        triangles,
        title="Error of the hot shape",
        caption=f"RMS {rms_mm:.2f} mm, largest {hausdorff_mm:.2f} mm",
        colours=error_colours(error_mm),
    )


def error_colours(error_mm: np.ndarray) -> Colours:
    """Return the colours of distances from the target [mm], positive above it, shape [n], float."""
    # The 98th percentile: a few far points must not bleach everything else.
    reach = max(float(np.percentile(np.abs(error_mm), 98)), 1e-3)
    label = "distance from the target [mm]\nblue: below it, red: above it"
    return Colours(values=error_mm, label=label, low=-reach, high=reach, colour_map="RdBu_r")
