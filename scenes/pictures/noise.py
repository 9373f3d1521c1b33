"""Picture of how the scores of noisy films spread."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from scenes.costs_in_words import KINDS
from scenes.whole_file import whole_file
from twin.score import Score

LEAST_BINS = 8
ROOM_FOR_LEGEND = 1.45


def draw_noise(
    path: str | Path,
    scores: Sequence[Score],
    planned: Score,
    contraction: Sequence[float],
    costs: dict[str, float] | None,
    *,
    caption: str,
) -> None:
    """Draw histograms of similarity and RMS, similarity over contraction, and what each error costs, into a PNG.

    The contraction is the one error that a strip of the same ink shows before the film is made: where it decides, a
    better measured calibration helps.

    Args:
        path: File to write, whole or not at all.
        scores: Of the noisy films.
        planned: Of the film as planned, on the same mesh.
        contraction: Of the noisy films, over that of the planned one.
        costs: What each kind of error costs in similarity, and all together; None where that is not known.
        caption: Written below: which noise, which mesh.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12.0, 8.4), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    (*panels,), (over, shares) = figure.subplots(2, 2)
    bins = max(LEAST_BINS, int(np.sqrt(len(scores))))
    for axes, name, label in zip(panels, ("ssim_eq4", "rms_mm"), ("SSIM, Eq. 4 [1]", "RMS distance [mm]"), strict=True):
        values = np.array([getattr(score, name) for score in scores])
        films, *_ = axes.hist(values, bins=bins, color="#9db8d2", edgecolor="white")
        axes.set_ylim(top=ROOM_FOR_LEGEND * np.max(films))
        low, middle, high = np.percentile(values, (10, 50, 90))
        axes.axvspan(low, high, color="#5b8db8", alpha=0.15, label=f"10 to 90 %: {low:.3f} to {high:.3f}")
        axes.axvline(middle, color="#2f5d8a", label=f"median: {middle:.3f}")
        as_planned = float(getattr(planned, name))
        axes.axvline(as_planned, color="black", linestyle="dashed", label=f"without noise: {as_planned:.3f}")
        axes.set_xlabel(label, fontsize=12)
        axes.set_ylabel("films", fontsize=12)
        axes.legend(fontsize=10)
        axes.yaxis.get_major_locator().set_params(integer=True)
    over.scatter(100.0 * np.asarray(contraction), [score.ssim_eq4 for score in scores], color="#2f5d8a", label="noisy")
    over.scatter([100.0], [planned.ssim_eq4], color="black", marker="x", label="without noise")
    over.set_xlabel("contraction of the whole film [% of the plan]", fontsize=12)
    over.set_ylabel("SSIM, Eq. 4 [1]", fontsize=12)
    over.legend(fontsize=10)
    if costs is None:
        shares.set_axis_off()
    else:
        dearest = sorted(costs, key=costs.__getitem__)
        bars = shares.barh([KINDS[kind] for kind in dearest], [costs[kind] for kind in dearest], color="#9db8d2")
        shares.bar_label(bars, fmt="%.3f", padding=3, fontsize=10)
        shares.margins(x=0.15)
        shares.locator_params(axis="x", nbins=5)
        shares.set_xlabel("expected cost to first order, SSIM [1]", fontsize=12)
    figure.suptitle(f"Scores of {len(scores)} films with errors of the process", fontsize=14)
    figure.supxlabel(caption, fontsize=11)
    with whole_file(path) as scratch:
        figure.savefig(scratch)
