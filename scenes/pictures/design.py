"""Pictures of an inverse design: the target beside the present shape, and in the end beside shape and error."""

from pathlib import Path

import numpy as np

from planner.target import Target, surface_mesh
from scenes.pictures.error_map import error_colours
from scenes.pictures.relief import Colours, half_height, relief_image
from scenes.whole_file import whole_file
from twin.score import Scored

SIZE_PX = (500, 600)
EDGE_SHARE = 1 / 100
"""Edge of the target's drawn triangles over the outline's longer side."""


class CurrentPicture:
    """The target beside the shape that a search has reached, drawn over and over."""

    def __init__(self, target: Target) -> None:
        """Draw the target."""
        vertices, triangles = surface_mesh(target, max(target.size_mm) * EDGE_SHARE)
        self._scale = half_height(vertices)
        self._target = relief_image(vertices, triangles, self._scale, size_px=SIZE_PX)

    def draw(self, path: str | Path, vertices_mm: np.ndarray, triangles: np.ndarray, *, caption: str) -> None:
        """Draw both into a PNG, whole or not at all: vertices [mm], shape [n, 3], and triangles, shape [m, 3]."""
        image = relief_image(vertices_mm, triangles, self._scale, size_px=SIZE_PX)
        _write(path, [self._target, image], ["Target", caption])


def draw_design(path: str | Path, target: Target, scored: Scored) -> None:
    """Draw target, predicted shape and its distance from the target side by side, in one scale, into a PNG."""
    vertices, triangles = surface_mesh(target, max(target.size_mm) * EDGE_SHARE)
    scale, score = half_height(vertices), scored.score
    error = error_colours(scored.error_mm)
    images = [
        relief_image(vertices, triangles, scale, size_px=SIZE_PX),
        relief_image(scored.vertices_mm, scored.triangles, scale, size_px=SIZE_PX),
        relief_image(scored.vertices_mm, scored.triangles, scale, colours=error, size_px=SIZE_PX),
    ]
    captions = [
        f"Target, {score.target_depth_mm:.1f} mm deep",
        f"Predicted from its passes, {score.depth_mm:.1f} mm deep",
        f"Error: RMS {score.rms_mm:.2f} mm, largest {score.hausdorff_mm:.2f} mm",
    ]
    title = f"{target.name}: inverse design, SSIM (Eq. 4) {100 * score.ssim_eq4:.1f} %"
    _write(path, images, captions, title=title, colours=error)


def _write(
    path: str | Path,
    images: list[np.ndarray],
    captions: list[str],
    *,
    title: str = "",
    colours: Colours | None = None,
) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    bar_in = 0.0 if colours is None else 1.0
    figure = Figure(figsize=(4.0 * len(images) + bar_in, 5.6), dpi=110, facecolor="white", layout="constrained")
    FigureCanvasAgg(figure)
    if title:
        figure.suptitle(title, fontsize=14)
    panels = figure.subplots(1, len(images))
    for axes, image, caption in zip(panels, images, captions, strict=True):
        axes.imshow(image)
        axes.set(xticks=[], yticks=[])
        axes.spines[:].set_visible(False)
        axes.set_xlabel(caption, fontsize=12)
    if colours is not None:
        mappable = ScalarMappable(Normalize(colours.low, colours.high), colours.colour_map)
        figure.colorbar(mappable, ax=list(panels), shrink=0.7).set_label(colours.label, fontsize=12)
    with whole_file(path) as scratch:
        figure.savefig(scratch)
