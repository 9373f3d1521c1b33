"""Pydantic's findings as the project's sentences: what, where, the value found, what is allowed."""

from typing import Any

from pydantic import ValidationError

TAGS = frozenset({"deposit", "reset_alignment", "scratch", "cure", "cut", "actuate", "saturating", "table"})
"""Names of tagged-union members, which pydantic puts into a field's path although no file has them there."""


def validation_sentences(error: ValidationError, source: str) -> tuple[str, ...]:
    """Translate each finding into one sentence that starts with the file and the field.

    A finding that repeats over many entries of a list is told once, with the first place and the count.
    """
    first: dict[tuple[str, str], str] = {}
    counts: dict[tuple[str, str], int] = {}
    for finding in error.errors(include_url=False, include_context=True):
        place = field_path(finding["loc"])
        key = (".".join(str(part) for part in finding["loc"] if isinstance(part, str)), finding["type"])
        first.setdefault(key, f"{source}: {place}: {_finding(finding)}")
        counts[key] = counts.get(key, 0) + 1
    return tuple(
        sentence + (f" (and {counts[key] - 1} more places likewise)" if counts[key] > 1 else "")
        for key, sentence in first.items()
    )


def field_path(location: tuple[int | str, ...]) -> str:
    """Write a field's place as in `layers[2].operations[1].passes[7].load_g`."""
    path = ""
    for place, part in enumerate(location):
        if isinstance(part, int):
            path += f"[{part}]"
        elif not (part in TAGS and place and (isinstance(location[place - 1], int) or location[place - 1] == "model")):
            path += f".{part}" if path else part
    return path or "whole file"


def _finding(finding: Any) -> str:
    kind, found = finding["type"], finding["input"]
    if kind == "missing":
        return "this field is missing; add it"
    if kind == "extra_forbidden":
        return f"unknown field (value {_short(found)}); remove it or correct its spelling"
    message = finding["msg"].removeprefix("Value error, ")
    message = message[:1].lower() + message[1:]
    if kind == "value_error":
        return f"{message}; correct it"
    return f"found {_short(found)}, {message}; correct it"


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
