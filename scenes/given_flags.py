"""Which flags of a group the user gave."""

from dataclasses import fields
from typing import Any


def given(flags: Any) -> list[str]:
    """Return the flags of a dataclass of flags that differ from their defaults, as they are written."""
    found = []
    for part in fields(flags):
        value, flag = getattr(flags, part.name), f"--{part.name.replace('_', '-')}"
        if value != part.default:
            found.append(flag if value is True else f"{flag} {value}")
    return found
