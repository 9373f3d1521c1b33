"""A layer as SVG in true size: one user unit is one millimetre."""

from pathlib import Path
from xml.sax.saxutils import escape

from planner.program import Layer, Point, Program

MARGIN_MM = 2.0
DIGITS = 6
STYLE = {
    "convex": 'stroke="#1f4e9c" stroke-width="0.15"',
    "concave": 'stroke="#b5401f" stroke-width="0.15" stroke-dasharray="0.6 0.4"',
}


def layer_svg(program: Program, layer: Layer) -> str:
    """Return the drawing of a layer: its passes in their order, the cut line and the deposited region.

    y runs up on the film and down in SVG: the drawing is turned over, so that it looks as the film does from above.
    Each pass carries its side, load and speeds as `data-` attributes.
    """
    xs, ys = zip(*program.film.outline_mm, strict=True)
    left, right, low, high = min(xs) - MARGIN_MM, max(xs) + MARGIN_MM, min(ys) - MARGIN_MM, max(ys) + MARGIN_MM

    def path(points: tuple[Point, ...]) -> str:
        return "M" + " L".join(f"{_number(x - left)} {_number(high - y)}" for x, y in points)

    width, height = _number(right - left), _number(high - low)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}mm" height="{height}mm" '
        f'viewBox="0 0 {width} {height}" fill="none" stroke-linecap="round" stroke-linejoin="round">',
        f"<title>{escape(program.name)}, layer {layer.index + 1} of {len(program.layers)} (1 = bottom), "
        f"{escape(program.digest)}</title>",
        f"<desc>Lengths in mm; film x = {_number(left)} + x, film y = {_number(high)} - y.</desc>",
        f'<path id="deposited" stroke="#999999" stroke-width="0.1" d="{path(program.film.outline_mm)} Z"/>',
        f'<path id="cut" stroke="#000000" stroke-width="0.2" d="{path(program.cut.line_mm)} Z"/>',
        '<g id="passes">',
    ]
    for number, stroke in enumerate(layer.passes, 1):
        loads, speeds = (" ".join(map(_number, values)) for values in (stroke.load_g, stroke.speed_mm_s))
        lines.append(
            f'<path id="pass-{number}" class="{stroke.side}" {STYLE[stroke.side]} data-load-g="{loads}" '
            f'data-speed-mm-s="{speeds}" d="{path(stroke.points_mm)}"/>'
        )
    return "\n".join([*lines, "</g>", "</svg>", ""])


def write_layer_svgs(folder: Path, program: Program) -> None:
    """Write layer_1.svg, the bottom, and so on."""
    for layer in program.layers:
        (folder / f"layer_{layer.index + 1}.svg").write_text(layer_svg(program, layer), encoding="utf-8")


def _number(value: float) -> str:
    text = f"{value:.{DIGITS}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
