"""NAMUR laboratory devices (IKA hot plates) on the wire: commands to bytes, bytes to replies.

Source: IKA operating instructions, "Interfaces and outputs" (C-MAG HS 7 control, Plate RCT digital): 9600 baud, 7 data
bits, even parity, 1 stop bit; capital letters; parts with blanks between them; commands and replies end with blank,
carriage return, line feed and have at most 80 characters; the device speaks only when asked. `IN_` is answered by one
line, a number with the channel after it (`25.3 2`); an `@` echoes its value; everything else is not answered at all.
"""

import re
from typing import Final

from planner.errors import InputError

END: Final = b" \r\n"
WATCHDOG_S: Final = (20, 1500)
"""Shortest and longest time of the device's own watchdog [s]."""

_COMMAND = re.compile(r"[A-Z][A-Z0-9_]*(?:@\d{1,4}| \d{1,4}(?:\.\d)?)?", re.ASCII)
_NUMBER = re.compile(r"(-?\d{1,4}(?:\.\d{1,3})?)(?: +(\d{1,2}))?", re.ASCII)
_CHANNEL = re.compile(r"IN_(?:PV|SP)_(\d{1,2})", re.ASCII)


def encode(command: str) -> bytes:
    """Return a command as it goes over the wire.

    Raises:
        InputError: if it is no command of NAMUR.
    """
    if not _COMMAND.fullmatch(command):
        raise InputError(
            f"hot plate: the command {command!r} cannot be sent, allowed are capital letters, digits and _, then a"
            " blank or @ and a number; correct it"
        )
    return command.encode("ascii") + END


def value(reply: str, command: str) -> float | None:
    """Read the number that a command was answered by; None if the reply is none, or belongs to another channel."""
    match = _NUMBER.fullmatch(reply)
    if match is None:
        return None
    asked = _CHANNEL.fullmatch(command)
    if asked is not None and match[2] is not None and match[2] != asked[1]:
        return None
    return float(match[1])
