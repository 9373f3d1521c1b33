"""The reports of a virtual Grbl, word for word as version 1.1h writes them."""

from collections.abc import Mapping, Sequence

from rig.dialects.grbl_settings import Axes
from rig.virtual.grbl_gcode import Modes

BANNER = "\r\nGrbl 1.1h ['$' for help]\r\n"
LOCK = "[MSG:'$H'|'$X' to unlock]\r\n"

_WHOLE = frozenset((0, 1, 2, 3, 4, 5, 6, 10, 13, 20, 21, 22, 23, 26, 32))


def status_report(
    state: str, position_mm: Axes, offset_mm: Axes, *, mask: int, free: tuple[int, int], feed_mm_min: float, extra: str
) -> str:
    """Return the answer to `?`; `mask` is setting 10, `free` the moves and bytes that still fit, `extra` goes last."""
    if mask & 1:
        fields = [state, f"MPos:{_axes(position_mm)}"]
    else:
        x, y, z = (a - b for a, b in zip(position_mm, offset_mm, strict=True))
        fields = [state, f"WPos:{_axes((x, y, z))}"]
    if mask & 2:
        fields.append(f"Bf:{free[0]},{free[1]}")
    fields.append(f"FS:{feed_mm_min:.0f},0")
    return f"<{'|'.join(fields)}{extra}>\r\n"


def offset_field(offset_mm: Axes) -> str:
    """Return the field of the work offset, which some reports have."""
    return f"|WCO:{_axes(offset_mm)}"


def settings_report(numbers: Mapping[int, float]) -> str:
    """Return the answer to `$$`."""
    return "".join(
        f"${number}={value:.0f}\r\n" if number in _WHOLE else f"${number}={value:.3f}\r\n"
        for number, value in sorted(numbers.items())
    )


def build_report(planner_moves: int, rx_bytes: int) -> str:
    """Return the answer to `$I`."""
    return f"[VER:1.1h.20190825:]\r\n[OPT:V,{planner_moves},{rx_bytes}]\r\n"


def offsets_report(systems_mm: Sequence[Axes], shift_mm: Axes) -> str:
    """Return the answer to `$#`."""
    lines = [f"[G{54 + index}:{_axes(origin)}]" for index, origin in enumerate(systems_mm)]
    zero = _axes((0.0, 0.0, 0.0))
    lines += [f"[G28:{zero}]", f"[G30:{zero}]", f"[G92:{_axes(shift_mm)}]", "[TLO:0.000]", f"[PRB:{zero}:0]"]
    return "".join(f"{line}\r\n" for line in lines)


def modes_report(modes: Modes) -> str:
    """Return the answer to `$G`."""
    return (
        f"[GC:{modes.motion} G{54 + modes.system} G17 G{20 if modes.inches else 21} G{91 if modes.relative else 90}"
        f" G94 M5 M{8 if modes.coolant else 9} T0 F{modes.feed_mm_min:.0f} S0]\r\n"
    )


def _axes(values: Axes) -> str:
    return ",".join(f"{value:.3f}" for value in values)
