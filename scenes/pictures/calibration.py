"""Picture of a calibration: radius against load at each speed, with its band, and the strips it comes from."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from planner.calibration import CalibrationFit
from planner.program import TableModel
from scenes.whole_file import whole_file

if TYPE_CHECKING:
    from matplotlib.axis import Axis

MOST_CURVES = 5
"""Speeds that are drawn: those of the strips if they are few, else some evenly in the logarithm."""
POINTS = 120


def draw_calibration(path: str | Path, fit: CalibrationFit) -> None:
    """Draw the fitted map, its band and the strips, outliers marked, into a PNG."""
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, LogNorm
    from matplotlib.figure import Figure

    record, strips = fit.calibration.record, fit.strips
    speeds = _speeds(strips.speed_mm_s[fit.kept])
    norm = LogNorm(strips.speed_mm_s.min(), strips.speed_mm_s.max())
    # The last yellows cannot be seen on white.
    colours = ListedColormap(matplotlib.colormaps["viridis"](np.linspace(0.0, 0.85, 256)))
    figure = Figure(figsize=(9.0, 6.4), dpi=130, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    load = np.geomspace(record.limits.load_g_min, record.limits.load_g_max, POINTS)
    for speed in speeds:
        radius, colour = fit.calibration.radius_mm(load, speed), colours(norm(speed))
        half = _band(fit, load, float(speed))
        axes.fill_between(load, radius * np.exp(-half), radius * np.exp(half), color=colour, alpha=0.13, linewidth=0)
        axes.plot(load, radius, color=colour, linewidth=1.8, label=f"{speed:.3g} mm/s")
    for top, marker, label in ((False, "o", "scratched at the bottom"), (True, "^", "scratched on top")):
        mine = strips.top == top
        if mine.any():
            axes.scatter(
                strips.load_g[mine], fit.strip_radius_mm[mine], c=strips.speed_mm_s[mine], norm=norm, cmap=colours,
                marker=marker, s=46, edgecolors="white", linewidths=0.8, zorder=3, label=label,
            )  # fmt: skip
    if fit.outliers:
        place = [outlier.load_g for outlier in fit.outliers], [outlier.radius_mm for outlier in fit.outliers]
        axes.scatter(*place, marker="x", s=130, color="#b00020", linewidths=2.0, zorder=4, label="left out")
        for outlier in fit.outliers:
            axes.annotate(
                f"row {outlier.row}", (outlier.load_g, outlier.radius_mm), xytext=(8, 6), textcoords="offset points",
                color="#b00020", fontsize=10,
            )  # fmt: skip
    axes.set_xscale("log")
    axes.set_yscale("log")
    _plain_ticks(axes.xaxis, list(load))
    _plain_ticks(axes.yaxis, [*fit.strip_radius_mm, record.limits.radius_mm_min, record.limits.radius_mm_max])
    axes.set_xlabel("load of the post [g]", fontsize=12)
    axes.set_ylabel("bending radius [mm]", fontsize=12)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=10, loc="upper right")
    bar = figure.colorbar(ScalarMappable(norm, colours), ax=axes)
    bar.set_ticks(list(speeds), labels=[f"{speed:.3g}" for speed in speeds])
    bar.minorticks_off()
    bar.set_label("speed [mm/s]", fontsize=12)
    figure.suptitle(f"Calibration '{record.name}'", fontsize=14)
    level = record.uncertainty.level if record.uncertainty else 0.0
    figure.supxlabel(
        f"{fit.kept.sum()} of {len(strips)} strips, {record.strip.width_mm:g} mm wide, from {strips.source}; "
        f"bands: the whole map at once, {level:.0%}",
        fontsize=11,
    )
    with whole_file(path) as scratch:
        figure.savefig(scratch)


def _speeds(found: np.ndarray) -> np.ndarray:
    own = np.unique(found)
    return own if len(own) <= MOST_CURVES else np.geomspace(own[0], own[-1], 4)


def _band(fit: CalibrationFit, load: np.ndarray, speed: float) -> np.ndarray:
    """Return the half width of the band in log radius at loads, shape [n], as the map itself between its nodes."""
    from scipy.interpolate import RegularGridInterpolator

    model, uncertainty = fit.calibration.record.model, fit.calibration.record.uncertainty
    if uncertainty is None or not isinstance(model, TableModel):
        return np.zeros(len(load))
    axes = np.log(model.load_g), np.log(model.speed_mm_s)
    inside = np.clip(np.log(load), axes[0][0], axes[0][-1])
    return RegularGridInterpolator(axes, np.array(uncertainty.band_log_radius))(
        np.column_stack([inside, np.full(len(load), np.log(speed))])
    )


def _plain_ticks(axis: "Axis", values: Sequence[float]) -> None:
    """Write 1, 2, 5, 10 and not powers of ten."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter

    low, high = min(values), max(values)
    every = [digit * 10.0**power for power in range(-3, 4) for digit in (1, 1.5, 2, 3, 5, 7)]
    axis.set_major_locator(FixedLocator([tick for tick in every if 0.8 * low <= tick <= 1.25 * high]))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())
