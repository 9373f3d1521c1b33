"""Marlin on the wire: numbered lines with a checksum to bytes, bytes to events.

Source: RepRap "G-code", line numbers and checksums, and Marlin 2's answers: the checksum is all bytes before `*`, by
exclusive or. A line is answered by `ok` once it is queued, which is not executed; one that is spoiled or out of order
by `Error:...`, `Resend: k`, usually `ok`. While it cannot answer yet Marlin says `echo:busy: processing` every 2 s.
"""

import re
from dataclasses import dataclass
from functools import reduce
from operator import xor
from typing import Final

from planner.errors import InputError

LINE_BYTES: Final = 96
"""Longest line with its end that Marlin takes."""
ANSWER_BYTES: Final = 512
"""Longest line that is understood; what Marlin says of itself (M115) has some 250."""

_COMMAND = re.compile(r"[GM]\d{1,4}(?: ?[A-Z](?:-?\d{1,9}(?:\.\d{0,4})?)?)*", re.ASCII)
_RESEND = re.compile(r"(?:Resend|rs):? ?N?(\d{1,9})", re.ASCII)
_NUMBER = r"(-?\d{1,9}(?:\.\d{1,6})?)"
_POSITION = re.compile(rf"X:{_NUMBER} Y:{_NUMBER} Z:{_NUMBER}(?: E:{_NUMBER})? Count X:(-?\d+) Y:(-?\d+) Z:(-?\d+)\s*")
_STEPS = re.compile(rf"(?:echo:)?\s*M92 X{_NUMBER} Y{_NUMBER} Z{_NUMBER}(?: .*)?", re.ASCII)


@dataclass(frozen=True, kw_only=True)
class Ok:
    """A line was queued."""


@dataclass(frozen=True, kw_only=True)
class Resend:
    """The line with this number is the next one that is taken."""

    number: int


@dataclass(frozen=True, kw_only=True)
class Busy:
    """It is alive, and still at what it was told."""


@dataclass(frozen=True, kw_only=True)
class Started:
    """It has started anew; what it was told before is void."""


@dataclass(frozen=True, kw_only=True)
class Failure:
    """Something is wrong; with a `Resend` after it only with the line."""

    text: str


@dataclass(frozen=True, kw_only=True)
class Position:
    """Where the axes are, counted by the steps really made."""

    steps: tuple[int, int, int]


@dataclass(frozen=True, kw_only=True)
class StepsPerMm:
    """The setting of M92."""

    steps_per_mm: tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Text:
    """Anything else."""

    text: str


Event = Ok | Resend | Busy | Started | Failure | Position | StepsPerMm | Text


def checksum(data: bytes) -> int:
    """Return all bytes by exclusive or."""
    return reduce(xor, data, 0)


def encode(command: str, number: int) -> bytes:
    """Return a command as a numbered line with its checksum.

    Raises:
        InputError: if it is no command, or too long.
    """
    if not _COMMAND.fullmatch(command):
        raise InputError(f"Command {command[:60]!r} for the stage is no G-code of Marlin's: correct it.")
    body = f"N{number} {command}".encode("ascii")
    line = body + f"*{checksum(body)}\n".encode("ascii")
    if len(line) > LINE_BYTES:
        raise InputError(
            f"Line {line[:20]!r}... for the stage has {len(line)} bytes, allowed are {LINE_BYTES}: split it."
        )
    return line


def understand(line: str) -> Event:
    """Understand one line from Marlin."""
    if line == "ok" or line.startswith("ok "):
        return Ok()
    if match := _RESEND.fullmatch(line):
        return Resend(number=int(match[1]))
    if line.startswith(("echo:busy:", "busy:")):
        return Busy()
    if line == "start":
        return Started()
    if line.startswith(("Error:", "!!")):
        return Failure(text=line)
    if match := _POSITION.fullmatch(line):
        x, y, z = (int(text) for text in match.groups()[-3:])
        return Position(steps=(x, y, z))
    if match := _STEPS.fullmatch(line):
        x, y, z = (float(text) for text in match.groups())
        return StepsPerMm(steps_per_mm=(x, y, z))
    return Text(text=line)
