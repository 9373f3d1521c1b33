"""A measured calibration as a TOML file that a person can read."""

import json
from collections.abc import Sequence
from typing import Any

from planner.program import CalibrationRecord

HEAD = """\
# Bending radius of calibration strips against the load and the speed of the post, fitted to measured strips.
# Loads in g, speeds in mm/s, radii in mm at 150 C. Give it to `lce plan --calibration`.
"""
COMMENTS = {
    "limits": "the range of the strips: settings outside it are refused",
    "strip": "the strips that were measured: layers bottom first, those that were scratched, and their width [mm]",
    "model": "one row for each load, in it one radius for each speed",
    "uncertainty": "of the logarithm of the radius, on the same grid: the half width of the band for the whole map at\n"
    "# once, and modes of maps that the strips leave possible; strip_log_radius is the scatter of one strip",
}


def calibration_toml(record: CalibrationRecord) -> str:
    """Return the record as TOML, with comments; `load_calibration` reads it back as it was."""
    document = record.model_dump(mode="json")
    top = {key: value for key, value in document.items() if not isinstance(value, dict)}
    tables = {key: value for key, value in document.items() if isinstance(value, dict)}
    parts = [HEAD, *(f"{key} = {_value(value)}\n" for key, value in top.items())]
    for name, table in tables.items():
        parts.append(f"\n{'# ' + COMMENTS[name] + chr(10) if name in COMMENTS else ''}[{name}]\n")
        parts += [f"{key} = {_value(value)}\n" for key, value in table.items()]
    return "".join(parts)


def _value(value: Any, indent: str = "") -> str:
    if isinstance(value, str):
        # A TOML basic string is a JSON string, but for the one control character that JSON lets pass.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Sequence):
        if value and isinstance(value[0], Sequence):
            inner = indent + "  "
            return "[\n" + "".join(f"{inner}{_value(row, inner)},\n" for row in value) + indent + "]"
        return "[" + ", ".join(_value(item) for item in value) + "]"
    return json.dumps(value)
