"""Several shapes of one film side by side, in one scale."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from scenes.pictures.relief import half_height, relief_image
from scenes.whole_file import whole_file

SIZE_PX = (400, 480)
COLUMNS = 4


def draw_side_by_side(
    path: str | Path,
    shapes_mm: Sequence[np.ndarray],
    triangles: np.ndarray,
    captions: Sequence[str],
    *,
    title: str,
    columns: int = COLUMNS,
) -> None:
    """Draw shapes in rows into a PNG, each with its caption and depth under it.

    Args:
        path: File to write, whole or not at all.
        shapes_mm: Vertices of each shape [mm], z towards the viewer, y up, shape [n, 3].
        triangles: Vertex indices, shape [m, 3], int.
        captions: Words for each.
        title: Written above all.
        columns: Most shapes in a row.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    columns = min(len(shapes_mm), columns)
    rows = -(-len(shapes_mm) // columns)
    scale = max(half_height(shape) for shape in shapes_mm)
    figure = Figure(figsize=(0.6 + 2.8 * columns, 0.7 + 3.7 * rows), dpi=110, facecolor="white", layout="compressed")
    FigureCanvasAgg(figure)
    figure.suptitle(title, fontsize=14)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels:
        axes.set(xticks=[], yticks=[])
        axes.spines[:].set_visible(False)
    for axes, shape, caption in zip(panels, shapes_mm, captions, strict=False):
        axes.imshow(relief_image(shape, triangles, scale, size_px=SIZE_PX))
        axes.set_xlabel(f"{caption}\n{np.ptp(shape[:, 2]):.1f} mm deep", fontsize=12)
    with whole_file(path) as scratch:
        figure.savefig(scratch)
