"""Picture of the depth images side by side, with the map of their similarity."""

from pathlib import Path

import numpy as np

from planner.target import Target
from scenes.whole_file import whole_file
from twin.scan import grey_image
from twin.score import Score


def draw_depth_images(
    path: str | Path,
    target: Target,
    target_depth_mm: np.ndarray,
    shape_depth_mm: np.ndarray,
    ssim_map: np.ndarray,
    score: Score,
) -> None:
    """Draw both depth images in one grey scale, and Eq. 4 around each pixel, into a PNG.

    Args:
        path: File to write.
        target: The target, for its name, box and range of heights.
        target_depth_mm: Depth image of the target [mm], NaN outside, shape [h, w], float.
        shape_depth_mm: Depth image of the shape [mm], NaN outside, shape [h, w], float.
        ssim_map: Eq. 4 of the window around each pixel, NaN where none counts, shape [h, w], float.
        score: The numbers to write.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    low, high = target.bounds_mm
    extent = (float(low[0]), float(high[0]), float(low[1]), float(high[1]))
    lowest, highest = float(np.nanmin(target.z_mm)), float(np.nanmax(target.z_mm))
    width, height = target.size_mm
    figure = Figure(figsize=(13.0, 1.8 + 3.2 * min(height / width, 2.0)), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(1, 3)
    heights = ((target_depth_mm, f"Target: {target.name}"), (shape_depth_mm, "Prediction"))
    for axes, (depth, title) in zip(panels[:2], heights, strict=True):
        # Beyond the target's range the picture saturates; the score is taken of the unclipped greys.
        grey = grey_image(depth, lowest, highest)
        axes.imshow(grey, cmap="gray", vmin=0, vmax=255, extent=extent, interpolation="nearest")
        axes.set_title(title, fontsize=13)
    similarity = panels[2].imshow(ssim_map, cmap="viridis", vmin=-1, vmax=1, extent=extent, interpolation="nearest")
    panels[2].set_title("Local similarity (Eq. 4)", fontsize=13)
    for axes in panels:
        axes.set_xlabel("x [mm]")
        axes.set_ylabel("y [mm]")
        axes.set_facecolor("black" if axes is not panels[2] else "white")
    greys = ScalarMappable(Normalize(lowest, highest), "gray")
    figure.colorbar(greys, ax=list(panels[:2]), shrink=0.9, label="height [mm]")
    figure.colorbar(similarity, ax=panels[2], shrink=0.9, label="SSIM [1]")
    figure.suptitle(
        f"SSIM (Eq. 4, same scale) {100 * score.ssim_eq4:.1f} %    "
        f"own scale {100 * score.ssim_eq4_own_scale:.1f} %    inside {100 * score.ssim_eq4_inside:.1f} %    "
        f"Gaussian {100 * score.ssim_gauss:.1f} %\n"
        f"RMS {score.rms_mm:.2f} mm ({score.rms_percent_of_diagonal:.1f} % of the diagonal)    "
        f"depth {score.depth_mm:.1f} of {score.target_depth_mm:.1f} mm",
        fontsize=13,
    )
    with whole_file(path) as scratch:
        figure.savefig(scratch)
