"""A preview of a layer's toolpath as G-code, for viewers; machines are driven by the rig, which audits what it does."""

from pathlib import Path

from planner.program import Layer, Program

LIFT_MM = 5.0
"""Height above the film on the way between passes."""
TRAVEL_MM_MIN = 600.0
WARNING = "preview: not for a machine without the rig's audit"


def layer_gcode(program: Program, layer: Layer) -> str:
    """Return the toolpath of a layer: mm, absolute, z = 0 on the film, feeds in mm/min, one G1 for each segment.

    Loads have no word in G-code: they stand in comments where they change.
    """
    lines = [
        f"; {WARNING}",
        f"; {_word(program.name)}, layer {layer.index + 1} of {len(program.layers)} (1 = bottom), "
        f"{len(layer.passes)} passes",
        f"; program {program.digest}",
        f"; calibration {_word(program.calibration.name)}, "
        f"{'a placeholder, not measured' if program.calibration.placeholder else 'measured'}",
        "G21 ; mm",
        "G90 ; absolute",
        "G94 ; feeds in mm/min",
        f"G0 Z{LIFT_MM:g}",
    ]
    load = None
    for number, stroke in enumerate(layer.passes, 1):
        lines.append(f"; pass {number}, {stroke.side}, {stroke.length_mm:.3f} mm")
        loads = list(stroke.load_g) if len(stroke.load_g) > 1 else list(stroke.load_g) * len(stroke.points_mm)
        (x, y), *rest = stroke.points_mm
        lines.append(f"G0 X{x:.4f} Y{y:.4f}")
        if loads[0] != load:
            load = loads[0]
            lines.append(f"; load {load:g} g")
        lines.append(f"G1 Z0 F{TRAVEL_MM_MIN:g}")
        for (x, y), speed, own in zip(rest, stroke.speed_mm_s, loads[1:], strict=True):
            lines.append(f"G1 X{x:.4f} Y{y:.4f} F{60.0 * speed:.3f}")
            if own != load:
                load = own
                lines.append(f"; load {load:g} g")
        lines.append(f"G0 Z{LIFT_MM:g}")
    return "\n".join([*lines, "M2", ""])


def write_layer_gcodes(folder: Path, program: Program) -> None:
    """Write layer_1.gcode, the bottom, and so on."""
    for layer in program.layers:
        (folder / f"layer_{layer.index + 1}.gcode").write_text(layer_gcode(program, layer), encoding="utf-8")


def _word(text: str) -> str:
    """Return text that cannot end its comment."""
    return " ".join(text.split())
