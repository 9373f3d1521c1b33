"""The passes of each layer with their times, for their playback."""

from itertools import accumulate
from typing import Any

import numpy as np

from planner.calibration import Calibration
from planner.program import Machine, Pass, Program, layer_times, pass_s
from scenes.pictures.plan import radius_colours, segment_radius_mm

SHADES = 64
DIGITS = 3


def pack_strokes(program: Program, machine: Machine) -> dict[str, Any]:
    """Collect passes, their starts on the clock of their layer, and their colours, as plain values for JSON.

    Layers with the same passes share them.
    """
    from matplotlib.colors import to_hex

    limits = program.calibration.limits
    colour_map, norm = radius_colours(limits)
    calibration = Calibration(program.calibration)
    groups: list[tuple[Pass, ...]] = []
    layers = []
    for layer, times in zip(program.layers, layer_times(program, machine), strict=True):
        if layer.passes not in groups:
            groups.append(layer.passes)
        # The time left to the cure is counted from the middle of each pass.
        starts = [
            times.total_s - left - pass_s(stroke, machine.stage) / 2
            for stroke, left in zip(layer.passes, times.pass_to_cure_s, strict=True)
        ]
        layers.append(
            {
                "passes": groups.index(layer.passes),
                "start_s": [round(start, DIGITS) for start in starts],
                "total_s": times.total_s,
            }
        )
    return {
        "layers": layers,
        "passes": [[_stroke(stroke, machine, calibration, norm) for stroke in group] for group in groups],
        "colours": [to_hex(colour_map(place)) for place in np.linspace(0.0, 1.0, SHADES)],
        "radius_mm": [limits.radius_mm_min, limits.radius_mm_max],
        "film_mm": program.film.outline_mm,
        "cut_mm": program.cut.line_mm,
        "line_width_mm": program.film.line_width_mm,
    }


def _stroke(stroke: Pass, machine: Machine, calibration: Calibration, norm: Any) -> dict[str, Any]:
    """Return a pass: its points, when each is reached after its start, and each segment's radius and colour."""
    radius = segment_radius_mm(calibration, stroke)
    # Starts and stops are shared out over the whole pass: the post moves a little too evenly.
    stretch = pass_s(stroke, machine.stage) / stroke.scratch_s
    run = (stretch * length / speed for length, speed in zip(stroke.segment_lengths_mm, stroke.speed_mm_s, strict=True))
    return {
        "points_mm": stroke.points_mm,
        "at_s": [round(at, DIGITS) for at in accumulate(run, initial=0.0)],
        "load_g": stroke.load_g,
        "speed_mm_s": stroke.speed_mm_s,
        "radius_mm": np.round(radius, DIGITS).tolist(),
        "colour": np.rint(np.clip(norm(radius), 0.0, 1.0) * (SHADES - 1)).astype(int).tolist(),
        "concave": stroke.side == "concave",
    }
