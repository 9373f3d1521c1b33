"""Picture of an inverse design's way: how near each design came, over time."""

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

from scenes.whole_file import whole_file
from twin.score import Score

if TYPE_CHECKING:
    from twin.inverse import Moment

STAGE_COLOURS = ("#5b8db8", "#5aa469", "#c9772f", "#8a5a9e")


def draw_search(path: str | Path, history: Sequence["Moment"], score: Score, *, title: str, paper_ssim: float) -> None:
    """Draw similarity and RMS of each design over time, stage by stage, into a PNG.

    Args:
        path: File to write, whole or not at all.
        history: The designs.
        score: What the finished Program is predicted to reach.
        title: Written above.
        paper_ssim: What the paper reached.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 6.4), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    above, below = figure.subplots(2, 1, sharex=True)
    stages = [list(group) for _, group in groupby(history, key=lambda moment: moment.stage)]
    for moments, colour in zip(stages, STAGE_COLOURS, strict=False):
        time_s = [moment.elapsed_s for moment in moments]
        style = {"color": colour, "marker": "o", "label": moments[0].stage}
        above.plot(time_s, [moment.ssim for moment in moments], **style)
        below.plot(time_s, [moment.rms_mm for moment in moments], **style)
    predicted = {"color": "black", "linewidth": 1.2}
    above.axhline(score.ssim_eq4, **predicted, label=f"predicted, passes: {score.ssim_eq4:.3f}")
    below.axhline(score.rms_mm, **predicted, label=f"predicted, passes: {score.rms_mm:.3f} mm")
    above.axhline(
        paper_ssim, color="#b00020", linestyle="dashed", label=f"the paper's best printed face: {paper_ssim:.3f}"
    )
    above.set_ylabel("SSIM, Eq. 4 [1]", fontsize=12)
    above.set_ylim(top=1.0)
    below.set_ylabel("RMS distance [mm]", fontsize=12)
    below.set_ylim(bottom=0.0)
    below.set_xlabel("time since the start [s]", fontsize=12)
    for axes in (above, below):
        axes.grid(alpha=0.3)
        axes.legend(fontsize=10)
    figure.suptitle(title, fontsize=14)
    with whole_file(path) as scratch:
        figure.savefig(scratch)
