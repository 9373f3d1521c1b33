"""Mettler-Toledo balances (MT-SICS) on the wire: commands to bytes, bytes to replies.

Source: Mettler-Toledo, MT-SICS reference manual 11780711, levels 0 and 1: capital letters, parts with blanks between
them, both ways ended with carriage return and line feed. `S` is answered once the weight is stable, `SI` at once:
`S S     100.00 g`, `S D ...` while it moves, `S I` if it cannot now (or did not become stable in the balance's own
time), `S +` and `S -` out of range; `Z` by `Z A`, `Z I`, `Z +`, `Z -`; `I4` by `I4 A "serial number"`. `ES`, `ET`,
`EL`: syntax, transmission and logical errors.
"""

import re
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

STABLE: Final = b"S\r\n"
AT_ONCE: Final = b"SI\r\n"
ZERO: Final = b"Z\r\n"
SERIAL_NUMBER: Final = b"I4\r\n"

_GRAMS: Final = {"g": 1.0, "kg": 1e3, "mg": 1e-3}
_WEIGHT = re.compile(r"S ([SD]) +(-?\d{1,6}(?:\.\d{1,6})?) (g|kg|mg)", re.ASCII)
_REFUSAL = re.compile(r"(S|Z) ([IL+-])", re.ASCII)
_IDENTITY = re.compile(r'I4 A "([^"]{1,40})"', re.ASCII)


class Outcome(StrEnum):
    """How a command ended."""

    DONE = "A"
    STABLE = "S"
    MOVING = "D"
    NOT_NOW = "I"
    WRONG_PARAMETER = "L"
    OVERLOAD = "+"
    UNDERLOAD = "-"
    ERROR = "E"
    """The balance did not understand the command, `ES`, `ET` or `EL`."""


@dataclass(frozen=True, kw_only=True)
class Reply:
    """One line from the balance."""

    command: str
    """What it answers: `S`, `Z`, `I4`, or nothing for an error, which does not say."""
    outcome: Outcome
    weight_g: float | None = None
    serial_number: str | None = None


def understand(line: str) -> Reply | None:
    """Understand a line; None if no command that is used here is answered so."""
    if match := _WEIGHT.fullmatch(line):
        weight_g = float(match[2]) * _GRAMS[match[3]]
        return Reply(command="S", outcome=Outcome(match[1]), weight_g=weight_g)
    if match := _REFUSAL.fullmatch(line):
        return Reply(command=match[1], outcome=Outcome(match[2]))
    if line == "Z A":
        return Reply(command="Z", outcome=Outcome.DONE)
    if match := _IDENTITY.fullmatch(line):
        return Reply(command="I4", outcome=Outcome.DONE, serial_number=match[1])
    if line in ("ES", "ET", "EL"):
        return Reply(command="", outcome=Outcome.ERROR)
    return None
