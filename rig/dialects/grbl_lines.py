"""What is said to a Grbl controller: lines, each whole in itself, and real-time bytes.

A move always has its `G1` and its feed. Should a line end get lost, the two lines on one have two words of a kind,
and Grbl refuses them instead of moving along their diagonal.
"""

from planner.errors import InputError

LINE_BYTES = 80
"""Longest line with its end that Grbl takes."""

STATUS = b"?"
HOLD = b"!"
RESUME = b"~"
RESET = b"\x18"
JOG_CANCEL = b"\x85"

HOME = b"$H\n"
IDENTIFY = b"$I\n"
SETTINGS = b"$$\n"
OFFSETS = b"$#\n"
METRIC_ABSOLUTE = b"G21G90G94G17G54\n"
SYNCHRONISE_S = 0.01
SYNCHRONISE = b"G4P0.01\n"
"""A pause of 0.01 s, which is acknowledged once all motion before it has ended."""


def encode_line(text: str) -> bytes:
    """Return a line of printable ASCII as bytes with its end.

    Raises:
        InputError: if a character is not printable ASCII or acts at once (`?!~`), or the line is too long.
    """
    for column, character in enumerate(text, start=1):
        if not " " <= character <= "~" or character in "?!~":
            raise InputError(
                f"Line {text[:LINE_BYTES]!r} for the stage has {character!r} in column {column}; allowed is printable"
                " ASCII without ? ! ~, which act at once: leave the character out."
            )
    if len(text) >= LINE_BYTES:
        raise InputError(
            f"Line {text[:20]!r}... for the stage has {len(text)} characters, allowed are {LINE_BYTES - 1}: split it."
        )
    return text.encode("ascii") + b"\n"


def move_line(
    *, speed_mm_s: float, x_mm: float | None = None, y_mm: float | None = None, z_mm: float | None = None
) -> bytes:
    """Return a straight move at a speed [mm/s] to a position in the work frame [mm]; axes left out stay."""
    return encode_line("G1" + _words(x_mm, y_mm, z_mm) + f"F{_number(60 * speed_mm_s)}")


def jog_line(
    *, speed_mm_s: float, x_mm: float | None = None, y_mm: float | None = None, z_mm: float | None = None
) -> bytes:
    """Return a jog at a speed [mm/s] to a position in the work frame [mm]; axes left out stay."""
    return encode_line("$J=G21G90" + _words(x_mm, y_mm, z_mm) + f"F{_number(60 * speed_mm_s)}")


def offset_line(x_mm: float, y_mm: float, z_mm: float) -> bytes:
    """Return the command that puts the origin of the work frame at a machine position [mm]."""
    return encode_line("G10L2P1" + _words(x_mm, y_mm, z_mm))


def _words(x_mm: float | None, y_mm: float | None, z_mm: float | None) -> str:
    return "".join(f"{axis}{_number(mm)}" for axis, mm in zip("XYZ", (x_mm, y_mm, z_mm), strict=True) if mm is not None)


def _number(value: float) -> str:
    # Four decimals are a tenth of a micrometre: far below a step.
    text = f"{value:.4f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
