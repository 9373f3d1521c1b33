"""A layer as DXF in mm, in the film's own frame."""

from pathlib import Path

from planner.program import Program

COLOURS = {"convex": 5, "concave": 1, "cut": 7, "deposited": 8}
"""AutoCAD colour indices: blue, red, black or white, grey."""


def write_layer_dxfs(folder: Path, program: Program) -> None:
    """Write layer_1.dxf, the bottom, and so on: passes on the DXF layers CONVEX and CONCAVE, in their order."""
    from ezdxf import units
    from ezdxf.filemanagement import new

    for layer in program.layers:
        document = new("R2010", setup=False)
        document.units = units.MM
        for name, colour in COLOURS.items():
            document.layers.add(name.upper(), color=colour)
        space = document.modelspace()
        for name, line in (("deposited", program.film.outline_mm), ("cut", program.cut.line_mm)):
            space.add_lwpolyline(line, close=True, dxfattribs={"layer": name.upper()})
        for stroke in layer.passes:
            space.add_lwpolyline(stroke.points_mm, dxfattribs={"layer": stroke.side.upper()})
        document.saveas(folder / f"layer_{layer.index + 1}.dxf")
