"""Picture of the hot film."""

from pathlib import Path

import numpy as np

from scenes.pictures.relief import draw_relief


def draw_hot_shape(
    path: str | Path,
    vertices_mm: np.ndarray,
    triangles: np.ndarray,
    *,
    title: str = "Predicted hot shape",
    caption: str = "",
) -> None:
    """Draw the hot shape into a PNG: vertices [mm], shape [n, 3], and triangles, shape [m, 3]."""
    draw_relief(path, vertices_mm, triangles, title=title, caption=caption)
