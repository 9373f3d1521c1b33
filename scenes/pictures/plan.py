"""Picture of a Program: the passes of each group of layers on the film."""

from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from planner.calibration import Calibration
from planner.program import CalibrationLimits, Layer, Machine, Pass, Program, layer_times, load_machine
from scenes.whole_file import whole_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap, Normalize

_DASH = 0.55
"""Share of each segment of a concave pass that is drawn: dashes that follow the passes' own steps."""
_COLUMNS = 2
_PANEL_IN = 5.2


def draw_plan(path: str | Path, program: Program, machine: Machine | None = None) -> None:
    """Draw the passes into a PNG: convex solid, concave dashed, coloured by bending radius.

    Neighbouring layers with the same passes share a panel; polydomain layers have none.

    Args:
        path: File to write.
        program: The Program.
        machine: For the times; None: the paper's machine.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure

    groups = [tuple(group) for _, group in groupby(program.layers, key=lambda layer: layer.passes)]
    groups = [group for group in groups if group[0].passes] or [program.layers]
    limits = program.calibration.limits
    colours, norm = radius_colours(limits)
    film = np.array(program.film.outline_mm)
    width, height = np.ptp(film, axis=0)
    columns = min(len(groups), _COLUMNS)
    rows = -(-len(groups) // columns)
    figure = Figure(
        figsize=(_PANEL_IN * columns + 1.2, 1.3 + rows * (0.6 + _PANEL_IN * min(max(height / width, 0.5), 1.8))),
        dpi=130,
        layout="constrained",
    )
    FigureCanvasAgg(figure)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels[len(groups) :]:
        axes.set_axis_off()
    times = layer_times(program, machine or load_machine())
    calibration = Calibration(program.calibration)
    for axes, group in zip(panels, groups, strict=False):
        _draw_passes(axes, group[0].passes, calibration, norm, colours)
        _draw_outlines(axes, program)
        axes.set_title(_title(group, times[group[0].index].total_s), fontsize=12)
    bar = figure.colorbar(ScalarMappable(norm, colours), ax=list(panels), shrink=0.75 / rows)
    ticks = np.geomspace(limits.radius_mm_min, limits.radius_mm_max, 5)
    bar.set_ticks(list(ticks), labels=[f"{tick:.1f}" for tick in ticks])
    bar.minorticks_off()
    bar.set_label("bending radius [mm]", fontsize=12)
    figure.suptitle(f"{program.name}: {program.inputs.method} plan", fontsize=14)
    note = "solid: convex, dashed: concave, black: cut line"
    if program.calibration.placeholder:
        figure.supxlabel(
            f"{note}\nplaceholder calibration: loads, speeds and radii are not measured", color="#b00020", fontsize=12
        )
    else:
        figure.supxlabel(f"{note}\ncalibration: {program.calibration.name}", fontsize=12)
    with whole_file(path) as scratch:
        figure.savefig(scratch)


def radius_colours(limits: CalibrationLimits) -> tuple["Colormap", "Normalize"]:
    """Return how radii within a calibration's limits are coloured: tight ones dark."""
    import matplotlib
    from matplotlib.colors import ListedColormap, LogNorm

    # The last yellows cannot be seen on white.
    colours = ListedColormap(matplotlib.colormaps["plasma"](np.linspace(0.0, 0.86, 256)))
    return colours, LogNorm(limits.radius_mm_min, limits.radius_mm_max)


def segment_radius_mm(calibration: Calibration, stroke: Pass) -> np.ndarray:
    """Return the bending radius that each segment of a pass gives [mm], shape [segments]."""
    load = np.array(stroke.load_g)
    load = (load[:-1] + load[1:]) / 2.0 if len(load) > 1 else load
    return calibration.radius_mm(load, np.array(stroke.speed_mm_s))


def _draw_passes(
    axes: "Axes", passes: tuple[Pass, ...], calibration: Calibration, norm: "Normalize", colours: "Colormap"
) -> None:
    from matplotlib.collections import LineCollection

    segments, radii = [], []
    for stroke in passes:
        points = np.array(stroke.points_mm)
        starts, ends = points[:-1], points[1:]
        if stroke.side == "concave":
            middle, half = (starts + ends) / 2.0, _DASH * (ends - starts) / 2.0
            starts, ends = middle - half, middle + half
        segments.append(np.stack([starts, ends], axis=1))
        radii.append(segment_radius_mm(calibration, stroke))
    if segments:
        lines = LineCollection(
            list(np.concatenate(segments)), array=np.concatenate(radii), cmap=colours, norm=norm, linewidths=1.1
        )
        axes.add_collection(lines)


def _draw_outlines(axes: "Axes", program: Program) -> None:
    for line, style in ((program.film.outline_mm, {"color": "0.6", "linewidth": 0.8}),
                        (program.cut.line_mm, {"color": "black", "linewidth": 1.4})):  # fmt: skip
        closed = np.array([*line, line[0]])
        axes.plot(closed[:, 0], closed[:, 1], **style)
    axes.set_aspect("equal")
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")


def _title(group: tuple[Layer, ...], seconds: float) -> str:
    """Layers counted from 1 at the bottom, as at the bench; passes, length and time of each layer."""
    first, last = group[0].index + 1, group[-1].index + 1
    layers = f"layer {first}" if first == last else f"layers {first} to {last}"
    passes = group[0].passes
    length = sum(float(np.linalg.norm(np.diff(np.array(stroke.points_mm), axis=0), axis=1).sum()) for stroke in passes)
    each = "" if first == last else "each "
    return f"{layers} (1 = bottom)\n{each}{len(passes)} passes, {length:.0f} mm, {seconds / 60:.0f} min"
