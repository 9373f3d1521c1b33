"""Measured calibration strips from a CSV file, or every reason why they are none."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from hashlib import sha256
from io import StringIO
from math import isfinite
from pathlib import Path

import numpy as np

from planner.errors import InputError

COLUMNS = ("load_g", "speed_mm_s", "radius_mm", "side", "width_mm", "repeat")
SIDES = ("bottom", "top")
ALLOWED = {
    "load_g": (0.05, 100.0, "g", "convert N (x 102), mN (x 0.102) or kg (x 1000)"),
    "speed_mm_s": (0.02, 20.0, "mm/s", "convert mm/min (x 1/60) or m/s (x 1000)"),
    "radius_mm": (1.0, 300.0, "mm", "convert cm (x 10), m (x 1000) or um (x 0.001), and give its size without a sign"),
    "width_mm": (0.2, 300.0, "mm", "convert cm (x 10) or m (x 1000)"),
}
"""Least and largest value of each column, its unit, and what a value outside was probably written in."""
LEAST_STRIPS, LEAST_LOADS, LEAST_SPEEDS = 8, 3, 2


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredStrips:
    """Strips as they were measured, in the order of the file."""

    row: np.ndarray
    """Line of the file, the header being line 1, shape [n], int."""
    load_g: np.ndarray
    """Post load [g], shape [n], float."""
    speed_mm_s: np.ndarray
    """Post speed [mm/s], shape [n], float."""
    radius_mm: np.ndarray
    """Bending radius at 150 C [mm], shape [n], float."""
    top: np.ndarray
    """Whether the top layers were scratched and not the bottom ones, shape [n], bool."""
    width_mm: np.ndarray
    """Width of the strip [mm], shape [n], float."""
    repeat: np.ndarray
    """Which strip of its setting it is, shape [n], int."""
    source: str
    """Name of the file."""
    digest: str
    """SHA-256 of the file, with `sha256:` before it."""
    unread_columns: tuple[str, ...]
    """Columns of the file that mean nothing to the project."""

    def __len__(self) -> int:
        """Return the number of strips."""
        return len(self.row)


def read_strips(path: str | Path) -> MeasuredStrips:
    """Read a CSV file with a header and the columns of `COLUMNS`, in any order; others are not read.

    Raises:
        InputError: with every problem found, each with the file, the line, the column, what was found and what is
            allowed: no such file, no text, no table, missing columns, wrong values, strips that tell no map.
    """
    path = Path(path)
    content, text = _text(path)
    lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
    if not lines:
        raise InputError(f"{path}: is empty, allowed is a table with the columns {', '.join(COLUMNS)}; add the strips.")
    header_row, header = lines[0]
    names = [name.strip() for name in _cells(header)]
    problems = _header_problems(path, header_row, header, names)
    if problems:
        # Without its columns the rest of the table would only give findings that mislead.
        raise InputError(problems)
    faults = _Faults(path)
    rows = [_row(number, dict(zip(names, _fields(number, line, names, faults), strict=False)), faults)
            for number, line in lines[1:]]  # fmt: skip
    complete = [row for row in rows if row is not None]
    problems = [*faults.sentences(), *([] if faults else _too_little(path, complete))]
    if problems:
        raise InputError(problems)
    columns = {name: np.array([row[name] for row in complete]) for name in complete[0]}
    return MeasuredStrips(
        **columns,
        source=path.name,
        digest=f"sha256:{sha256(content).hexdigest()}",
        unread_columns=tuple(name for name in names if name not in COLUMNS),
    )


class _Faults:
    """Faults of cells: one that many rows of a column share is told once, with the first row and the count."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._first: dict[tuple[str, str], tuple[str, int]] = {}

    def __bool__(self) -> bool:
        return bool(self._first)

    def add(self, kind: str, row: int, column: str, sentence: str) -> None:
        first, count = self._first.get((kind, column), (f"row {row}, {column}: {sentence}", 0))
        self._first[kind, column] = first, count + 1

    def sentences(self) -> list[str]:
        return [
            f"{self._path}, {first}" + (f" (and {count - 1} more rows likewise)" if count > 1 else "")
            for first, count in self._first.values()
        ]


def _text(path: Path) -> tuple[bytes, str]:
    """Return a file's bytes and its text without the mark that some programs put before it."""
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: no such file of strips; check the path.") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error}); check the file.") from None
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path}: byte {error.start} is no UTF-8 text, allowed is a CSV file in UTF-8; save it as 'CSV UTF-8'."
        ) from None
    if "\0" in text:
        raise InputError(f"{path}: holds zero bytes, allowed is a CSV file in UTF-8; save it as 'CSV UTF-8'.")
    return content, text


def _cells(line: str) -> list[str]:
    return next(csv.reader(StringIO(line)), [])


def _header_problems(path: Path, row: int, header: str, names: list[str]) -> list[str]:
    for sign, word in ((";", "semicolons"), ("\t", "tabs")):
        if sign in header and len(names) < len(COLUMNS):
            return [
                f"{path}, row {row}: the columns are separated by {word}, allowed are commas between columns and "
                "points in numbers (2.4, not 2,4); save it as a CSV file with commas."
            ]
    problems = []
    for name in dict.fromkeys(name for name in names if names.count(name) > 1 and name in COLUMNS):
        problems.append(
            f"{path}, row {row}, {name}: the header has this column {names.count(name)} times, allowed is once; "
            "remove or rename the others."
        )
    missing = [name for name in COLUMNS if name not in names]
    if missing:
        unknown = [name for name in names if name not in COLUMNS]
        close = [(name, get_close_matches(name, unknown, n=1, cutoff=0.5)) for name in missing]
        meant = "; ".join(f"is {found[0]!r} meant for {name}?" for name, found in close if found)
        problems.append(
            f"{path}, row {row}: the header is {', '.join(map(repr, names))} and lacks {', '.join(missing)}, allowed "
            f"are {', '.join(COLUMNS)} in any order; {meant or 'add them to the first row.'}"
        )
    return problems


def _fields(row: int, line: str, names: list[str], faults: _Faults) -> list[str]:
    cells = _cells(line)
    if len(cells) != len(names):
        hint = "write numbers with points (2.4, not 2,4)" if len(cells) > len(names) else "fill the empty ones"
        faults.add(
            "count", row, "whole row", f"found {len(cells)} values, the header has {len(names)} columns; {hint}."
        )
        return []
    return cells


def _row(row: int, cells: dict[str, str], faults: _Faults) -> dict[str, float | int | bool] | None:
    """Return a row's values, None if some are wrong."""
    if not cells:
        return None
    found: dict[str, float | int | bool | None] = {"row": row}
    for name, (low, high, unit, hint) in ALLOWED.items():
        found[name] = _number(row, name, cells[name].strip(), (low, high), unit, hint, faults)
    side = cells["side"].strip()
    if side not in SIDES:
        close = get_close_matches(side.lower(), (*SIDES, "convex", "concave"), n=1)
        meant = {"convex": "bottom", "concave": "top"}.get(close[0], close[0]) if close else None
        hint = f"did you mean {meant}?" if meant else "bottom layers bend convex, top layers concave."
        faults.add("side", row, "side", f"found {side!r}, allowed are bottom and top; {hint}")
    found["top"] = side == "top"
    repeat = cells["repeat"].strip()
    if not (repeat.isascii() and repeat.isdigit() and 1 <= int(repeat) < 10**6):
        faults.add("repeat", row, "repeat", f"found {repeat!r}, allowed is a whole number from 1; number the strips.")
        return None
    found["repeat"] = int(repeat)
    complete = {name: value for name, value in found.items() if value is not None}
    return complete if len(complete) == len(found) and side in SIDES else None


def _number(
    row: int, column: str, text: str, allowed: tuple[float, float], unit: str, hint: str, faults: _Faults
) -> float | None:
    low, high = allowed
    try:
        value = float(text)
    except ValueError:
        kind = "write numbers with points (2.4, not 2,4)" if "," in text else "correct it, or remove the row"
        faults.add("text", row, column, f"found {text!r}, allowed is a number from {low:g} to {high:g} {unit}; {kind}.")
        return None
    if not (isfinite(value) and low <= value <= high):
        kind = "sign" if value <= 0 else "range"
        faults.add(kind, row, column, f"found {text}, allowed are {low:g} to {high:g} {unit}; {hint}.")
        return None
    return value


def _too_little(path: Path, rows: Sequence[dict[str, float | int | bool]]) -> list[str]:
    """Say why too few strips, loads or speeds tell no map."""
    problems = []
    if len(rows) < LEAST_STRIPS:
        problems.append(
            f"{path}: has {len(rows)} strips, allowed are {LEAST_STRIPS} or more: four numbers and the scatter are "
            "fitted; measure more strips, 20 are a good number."
        )
    for column, unit, least, why in (
        ("load_g", "g", LEAST_LOADS, "how the radius saturates with load"),
        ("speed_mm_s", "mm/s", LEAST_SPEEDS, "how the radius grows with speed"),
    ):
        values = sorted({float(row[column]) for row in rows})
        if rows and len(values) < least:
            listed = ", ".join(f"{value:g}" for value in values)
            problems.append(
                f"{path}, all rows, {column}: found only {listed} {unit}, allowed are {least} or more different "
                f"values: fewer do not tell {why}; measure strips at others."
            )
    return problems
