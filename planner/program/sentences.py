"""Pydantic's findings as the project's sentences: what, where, the value found, what is allowed."""

from difflib import get_close_matches
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

TAGS = frozenset({"deposit", "reset_alignment", "scratch", "cure", "cut", "actuate", "saturating", "table"})
"""Names of tagged-union members, which pydantic puts into a field's path although no file has them there."""


def validation_sentences(error: ValidationError, source: str, model: type[BaseModel] | None = None) -> tuple[str, ...]:
    """Translate each finding into one sentence that starts with the file and the field.

    A finding that repeats over many entries of a list is told once, with the first place and the count. With the
    model, an unknown field is told with the nearest of those that are allowed in its place.
    """
    first: dict[tuple[str, str], str] = {}
    counts: dict[tuple[str, str], int] = {}
    for finding in error.errors(include_url=False, include_context=True):
        place = field_path(finding["loc"])
        key = (".".join(str(part) for part in finding["loc"] if isinstance(part, str)), finding["type"])
        first.setdefault(key, f"{source}: {place}: {_finding(finding, model)}")
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


def _finding(finding: Any, model: type[BaseModel] | None) -> str:
    kind, found = finding["type"], finding["input"]
    if kind == "missing":
        return "this field is missing; add it"
    if kind == "extra_forbidden":
        names = _allowed(model, finding["loc"][:-1]) if model else []
        close = get_close_matches(str(finding["loc"][-1]), names, n=1)
        hint = f"did you mean {close[0]}?" if close else "remove it or correct its spelling"
        return f"unknown field (value {_short(found)}); {hint}"
    message = finding["msg"].removeprefix("Value error, ")
    message = message[:1].lower() + message[1:]
    if kind == "value_error":
        return f"{message}; correct it"
    return f"found {_short(found)}, {message}; correct it"


def _allowed(model: Any, location: tuple[int | str, ...]) -> list[str]:
    """Return the fields that are allowed at a place of a model, those of all members where it is one of several."""
    models = [model]
    for part in location:
        if not isinstance(part, int) and part not in TAGS:
            models = [inner for one in models if part in one.model_fields for inner in _models(one.model_fields[part])]
    return sorted({name for one in models for name in one.model_fields})


def _models(field: Any) -> list[type[BaseModel]]:
    """Return the models that a field's annotation names, however deep."""
    found, open_ = [], [field.annotation]
    while open_:
        part = open_.pop()
        if isinstance(part, type) and issubclass(part, BaseModel):
            found.append(part)
        open_ += get_args(part)
    return found


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
