"""The G-code of a virtual Grbl: one line of text into what is to be done, or the number of the error that it gives."""

import re
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from rig.dialects.grbl_settings import Axes

LINE_CHARACTERS = 79
ZERO: Axes = (0.0, 0.0, 0.0)

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)")
_WORDS = frozenset("FGIJKLMNPRSTXYZ")
_NOT_NEGATIVE = frozenset("FNPST")
# group: words of one group exclude each other on a line
_GROUPS: dict[str, str] = {
    **dict.fromkeys(("G0", "G1", "G80"), "motion"),
    **dict.fromkeys(("G4", "G10", "G53", "G92", "G92.1"), "non-modal"),
    **dict.fromkeys(("G20", "G21"), "units"),
    **dict.fromkeys(("G90", "G91"), "distance"),
    **dict.fromkeys(("G54", "G55", "G56", "G57", "G58", "G59"), "coordinates"),
    **dict.fromkeys(("M0", "M2", "M30"), "stopping"),
    **dict.fromkeys(("M3", "M4", "M5"), "spindle"),
    **dict.fromkeys(("M8", "M9"), "coolant"),
    "G17": "plane",
    "G40": "cutter",
    "G49": "length",
    "G61": "path",
    "G91.1": "arc",
    "G94": "feed",
}


class GcodeError(Exception):
    """A line that Grbl answers with `error:N`."""

    def __init__(self, number: int) -> None:
        super().__init__(f"error:{number}")
        self.number = number


@dataclass(frozen=True, kw_only=True)
class Modes:
    """What holds from line to line."""

    motion: Literal["G0", "G1", "G80"] = "G0"
    inches: bool = False
    relative: bool = False
    system: int = 0
    """Work coordinate system, 0 for G54."""
    feed_mm_min: float = 0.0
    coolant: bool = False


@dataclass(frozen=True, kw_only=True)
class Block:
    """A line that was understood, in the order in which Grbl does its parts."""

    modes: Modes
    waits: bool = False
    """Whether all motion must end first."""
    dwell_s: float | None = None
    system_offset: tuple[int, Axes] | None = None
    """Work coordinate system and its new origin in machine positions [mm]."""
    shift_mm: Axes | None = None
    """New offset of G92 [mm]."""
    target_mm: Axes | None = None
    """Where to move, in machine positions [mm]."""
    rapid: bool = False
    ends: bool = False
    pauses: bool = False


@dataclass(frozen=True, kw_only=True)
class Frame:
    """What positions on a line refer to."""

    position_mm: Axes
    """Where the last queued move ends, in machine positions [mm]."""
    systems_mm: tuple[Axes, ...]
    shift_mm: Axes


@dataclass
class _Line:
    codes: dict[str, str] = field(default_factory=dict)
    """Code of each group."""
    values: dict[str, float] = field(default_factory=dict)


def strip_line(raw: bytes) -> str:
    """Return a line as Grbl keeps it: no blanks, no comments, capital letters."""
    text = re.sub(r"\([^)]*\)?|;.*", "", raw.decode("latin-1"))
    return "".join(character for character in text if character > " " and character != "/").upper()


def parse_block(text: str, modes: Modes, frame: Frame, *, jog: bool = False) -> Block:
    """Understand a stripped line.

    Raises:
        GcodeError: with the number of Grbl's error.
    """
    line = _read_words(text)
    codes, values = line.codes, dict(line.values)
    if jog and (set(codes) - {"units", "distance", "non-modal"} or codes.get("non-modal", "G53") != "G53"):
        raise GcodeError(16)
    non_modal = codes.get("non-modal")
    axes = {axis for axis in "XYZ" if axis in values}
    values.pop("N", None)
    for ignored in "ST":
        values.pop(ignored, None)

    modes = _changed(modes, codes)
    unit = 25.4 if modes.inches else 1.0
    if "F" in values:
        modes = replace(modes, feed_mm_min=values.pop("F") * unit)
    elif jog:
        raise GcodeError(22)
    given = {axis: values.pop(axis) * unit for axis in axes}
    made = Block(modes=modes, waits=bool({"spindle", "coolant", "stopping"} & set(codes)))
    if non_modal == "G4":
        if "P" not in values:
            raise GcodeError(28)
        made = replace(made, waits=True, dwell_s=values.pop("P"))
    elif non_modal == "G10":
        made, given = replace(made, waits=True, system_offset=_new_system(values, given, modes, frame)), {}
    elif non_modal in ("G92", "G92.1"):
        if non_modal == "G92" and not given:
            raise GcodeError(26)
        made = replace(made, shift_mm=_new_shift(given, modes, frame) if non_modal == "G92" else ZERO)
        given = {} if non_modal == "G92" else given
    if given:
        made = _moved(made, given, frame, machine=non_modal == "G53", jog=jog)
    if values:
        raise GcodeError(36)
    stopping = codes.get("stopping")
    return replace(made, ends=stopping in ("M2", "M30"), pauses=stopping == "M0")


def _read_words(text: str) -> _Line:
    line, at = _Line(), 0
    while at < len(text):
        letter = text[at]
        if not ("A" <= letter <= "Z"):
            raise GcodeError(1)
        number = _NUMBER.match(text, at + 1)
        if number is None:
            raise GcodeError(2)
        at = number.end()
        value = float(number.group())
        if letter not in _WORDS:
            raise GcodeError(20)
        if letter in "GM":
            code = f"{letter}{value:g}"
            group = _GROUPS.get(code)
            if group is None:
                raise GcodeError(20)
            if group in line.codes:
                raise GcodeError(21)
            line.codes[group] = code
        else:
            if letter in line.values:
                raise GcodeError(25)
            if value < 0 and letter in _NOT_NEGATIVE:
                raise GcodeError(4)
            line.values[letter] = value
    return line


def _changed(modes: Modes, codes: dict[str, str]) -> Modes:
    changes: dict[str, Any] = {}
    if "motion" in codes:
        changes["motion"] = codes["motion"]
    if "units" in codes:
        changes["inches"] = codes["units"] == "G20"
    if "distance" in codes:
        changes["relative"] = codes["distance"] == "G91"
    if "coordinates" in codes:
        changes["system"] = int(codes["coordinates"][1:]) - 54
    if "coolant" in codes:
        changes["coolant"] = codes["coolant"] == "M8"
    return replace(modes, **changes)


def _new_system(values: dict[str, float], given: dict[str, float], modes: Modes, frame: Frame) -> tuple[int, Axes]:
    if not given:
        raise GcodeError(26)
    if "P" not in values or "L" not in values:
        raise GcodeError(28)
    kind, number = values.pop("L"), int(values.pop("P"))
    if kind not in (2, 20):
        raise GcodeError(20)
    if not 0 <= number <= len(frame.systems_mm):
        raise GcodeError(29)
    system = number - 1 if number else modes.system
    old = frame.systems_mm[system]
    origin = []
    for axis, name in enumerate("XYZ"):
        value = given.get(name)
        if value is not None and kind == 20:
            value = frame.position_mm[axis] - frame.shift_mm[axis] - value
        origin.append(old[axis] if value is None else value)
    return system, (origin[0], origin[1], origin[2])


def _new_shift(given: dict[str, float], modes: Modes, frame: Frame) -> Axes:
    system = frame.systems_mm[modes.system]
    x, y, z = (
        frame.position_mm[axis] - system[axis] - given[name] if name in given else frame.shift_mm[axis]
        for axis, name in enumerate("XYZ")
    )
    return (x, y, z)


def _moved(made: Block, given: dict[str, float], frame: Frame, *, machine: bool, jog: bool) -> Block:
    modes = made.modes
    if modes.motion == "G80" and not jog:
        raise GcodeError(31)
    if (jog or modes.motion == "G1") and modes.feed_mm_min == 0:
        raise GcodeError(22)
    shift = made.shift_mm or frame.shift_mm
    target = list(frame.position_mm)
    for axis, name in enumerate("XYZ"):
        if name not in given:
            continue
        if machine:
            target[axis] = given[name]
        elif modes.relative:
            target[axis] += given[name]
        else:
            target[axis] = given[name] + frame.systems_mm[modes.system][axis] + shift[axis]
    return replace(made, target_mm=(target[0], target[1], target[2]), rapid=modes.motion == "G0" and not jog)
