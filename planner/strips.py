"""Calibration strips: rectangles scratched all over at one load and one speed, to measure how far they bend."""

from importlib.metadata import version
from typing import Literal

import numpy as np

from planner.calibration import Calibration
from planner.errors import InputError
from planner.program import Actuate, CreatedBy, Cut, Film, Inputs, Layer, Pass, Program
from planner.toolpaths import LINE_WIDTH_MM, aligned_layers

LAYER_THICKNESS_MM = (0.2, 0.2, 0.2, 0.2)
RIM_MM = 3.0
"""Width of the deposited rim around the cut line: passes start and end in it, so that the strip has no line ends."""


def strip_program(
    calibration: Calibration,
    *,
    length_mm: float,
    width_mm: float,
    radius_mm: float,
    side: Literal["convex", "concave"] = "convex",
    name: str = "strip",
) -> Program:
    """Return the Program of a strip that the calibration promises to bend to one radius.

    ::

        y ^   +------------------------+   deposited
          |   |  ====================  |   passes along x, a line width apart, to and fro,
          |   |  ====================  |   beyond the cut line on all sides
          |   +------------------------+
          +----> x (director)

    Args:
        calibration: map from radius to load and speed.
        length_mm: length of the strip along the passes [mm].
        width_mm: its width [mm]; a strip narrower than about 30 mm bends more than a wide one, up to 4/3.
        radius_mm: bending radius of a wide strip at full temperature [mm].
        side: which pair of layers is scratched.
        name: name of the Program.

    Raises:
        InputError: if a length is not positive, or the radius is outside the calibration's range.
    """
    limits = calibration.record.limits
    problems = [
        f"strip {name}: {label} is {value:g} mm, allowed is a positive length; give for example {example} mm."
        for label, value, example in (("length", length_mm, 20), ("width", width_mm, 30))
        if not value > 0.0
    ]
    stack = (LAYER_THICKNESS_MM, aligned_layers(len(LAYER_THICKNESS_MM), "convex"))
    wanted_mm = float(calibration.strip_radius_mm(radius_mm, *stack)) if radius_mm > 0.0 else radius_mm
    if not limits.radius_mm_min <= wanted_mm <= limits.radius_mm_max:
        problems.append(
            f"strip {name}: radius is {radius_mm:g} mm, the calibration '{calibration.record.name}' reaches "
            f"{limits.radius_mm_min:g} to {limits.radius_mm_max:g} mm with its own strips; choose a radius in this "
            "range."
        )
    if problems:
        raise InputError(problems)
    settings = calibration.settings_for(wanted_mm)
    if settings.clamped[0]:
        raise InputError(
            f"strip {name}: no load and speed of the calibration '{calibration.record.name}' give {radius_mm:g} mm, "
            f"the nearest is {settings.radius_mm[0]:.3g} mm; choose that, or correct the calibration's range."
        )
    reach = 0.5 * length_mm + LINE_WIDTH_MM
    count = int(np.ceil(width_mm / LINE_WIDTH_MM)) + 2
    rows = LINE_WIDTH_MM * (np.arange(count) - 0.5 * (count - 1))
    passes = tuple(
        Pass(
            points_mm=((-way * reach, float(row)), (way * reach, float(row))),
            speed_mm_s=(float(settings.speed_mm_s[0]),),
            load_g=(float(settings.load_g[0]),),
            side=side,
        )
        for row, way in zip(rows, np.resize((1.0, -1.0), count), strict=True)
    )
    half = np.array((0.5 * length_mm, 0.5 * width_mm))
    chosen = aligned_layers(len(LAYER_THICKNESS_MM), side)
    return Program(
        name=name,
        seed=0,
        created_by=CreatedBy(name="lce-twin", version=version("lce-twin")),
        inputs=Inputs(
            method="strip",
            settings={"length_mm": length_mm, "width_mm": width_mm, "radius_mm": radius_mm, "side": side},
        ),
        calibration=calibration.record,
        film=Film(outline_mm=_rectangle(half + RIM_MM), layer_thickness_mm=LAYER_THICKNESS_MM),
        layers=tuple(
            Layer.of(index, thickness, passes if index in chosen else ())
            for index, thickness in enumerate(LAYER_THICKNESS_MM)
        ),
        finish=(Cut(line_mm=_rectangle(half)), Actuate()),
    )


def _rectangle(half_mm: np.ndarray) -> tuple[tuple[float, float], ...]:
    x, y = (float(value) for value in half_mm)
    return ((-x, -y), (x, -y), (x, y), (-x, y))
