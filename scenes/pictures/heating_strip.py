"""Picture of a heating for print: a few shapes of the rising sheet in a row, each with the plate's temperature."""

from pathlib import Path

import numpy as np

from scenes.pictures.heating_way import heating_way
from scenes.pictures.side_by_side import draw_side_by_side

COLUMNS = 6


def draw_heating_strip(
    path: str | Path,
    temperature_c: np.ndarray,
    vertices_mm: np.ndarray,
    triangles: np.ndarray,
    count: int,
    *,
    title: str,
) -> None:
    """Draw `count` shapes along the way of a heating, the first cold and the last hot, in rows of six into a PNG.

    Args:
        path: file to write, whole or not at all.
        temperature_c: temperature of the plate at each shape that was calculated [C], shape [k].
        vertices_mm: these shapes [mm], shape [k, n, 3].
        triangles: vertex indices, shape [m, 3], int.
        count: number of shapes to draw, two or more.
        title: written above.
    """
    way = heating_way(temperature_c, vertices_mm)
    shown = [way.at(time) for time in np.linspace(0.0, 1.0, count)]
    draw_side_by_side(
        path,
        [shape for shape, _ in shown],
        triangles,
        [f"{plate_c:.0f} \N{DEGREE SIGN}C" for _, plate_c in shown],
        title=title,
        columns=COLUMNS,
    )
