"""Cases: a target and the settings to plan and predict it with, from a TOML file."""

import dataclasses
import tomllib
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, Field, ValidationError

from planner.errors import InputError
from planner.program import validation_sentences
from planner.target import Target
from scenes.case_expected import Expected, Toleranced
from scenes.case_target import CasePart, CaseTarget, Positive

CASES = Path(__file__).parent / "cases"
"""Folder of the built-in cases, one TOML file each."""


class PlanSettings(CasePart):
    """How the case is planned."""

    method: Literal["perpendicular", "maximum"] = "perpendicular"
    flattening: Literal["arap", "grid"] = "arap"
    tracer: Literal["greedy", "dense"] = "greedy"
    margin_mm: Annotated[float, Field(ge=0)] = 0.0
    seed: Annotated[int, Field(ge=0)] = 0


class PredictSettings(CasePart):
    """How the case is predicted."""

    mesh_mm: Positive = 0.6
    temperature_c: Annotated[float, Field(gt=0, le=300)] = 150.0
    support: Literal["plate", "free"] = "plate"
    seed: Annotated[int, Field(ge=0)] = 0


class Case(CasePart):
    """One scene: what to make, how to plan it and how to predict it."""

    name: Annotated[str, Field(min_length=1)]
    description: Annotated[str, Field(min_length=1)]
    """One line that says what the case shows."""
    target: CaseTarget
    plan: PlanSettings = PlanSettings()
    predict: PredictSettings = PredictSettings()
    expected: Expected | None = None
    """What the tests of fidelity hold the case to."""

    def make_target(self) -> Target:
        """Make the target surface, named after the case."""
        return dataclasses.replace(self.target.make(), name=self.name)


def list_cases() -> tuple[Case, ...]:
    """Load all built-in cases, by name."""
    return tuple(_read(path) for path in sorted(CASES.glob("*.toml")))


def load_case(name_or_path: str | Path) -> Case:
    """Load a built-in case by its name, or a case file (`.toml`) by its path.

    Raises:
        InputError: There is no such case or file, or the file is no valid case; tells every problem.
    """
    text = str(name_or_path)
    names = sorted(path.stem for path in CASES.glob("*.toml"))
    if text in names:
        return _read(CASES / f"{text}.toml")
    path = Path(text)
    if path.suffix == ".toml" and path.is_file():
        return _read(path)
    if path.suffix == ".toml":
        raise InputError(f"{text}: no such case file; give an existing .toml or one of {', '.join(names)}.")
    close = get_close_matches(text, names, n=1)
    hint = f"did you mean {close[0]}?" if close else "`lce scenes` lists them."
    raise InputError(f"{text}: no built-in case has this name; allowed are {', '.join(names)}; {hint}")


def _read(path: Path) -> Case:
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"{path}: cannot be read as TOML ({error}); correct the file.") from error
    try:
        return Case.model_validate(document)
    except ValidationError as error:
        unknown = [finding for finding in error.errors() if finding["type"] == "extra_forbidden"]
        problems = [_unknown_key(path, finding["loc"], document) for finding in unknown]
        others = [line for line in validation_sentences(error, str(path)) if ": unknown field" not in line]
        raise InputError([*problems, *others]) from None


def _unknown_key(path: Path, location: tuple[int | str, ...], document: dict[str, Any]) -> str:
    """Say which key is unknown, what is allowed in its table, and what was probably meant."""
    key = str(location[-1])
    table = str(location[0]) if len(location) > 1 else ""
    tables = {"": Case, "plan": PlanSettings, "predict": PredictSettings, "expected": Expected}
    if table == "target":
        kind = document["target"]["kind"]
        allowed = next(part for part in _target_parts() if kind in get_args(part.model_fields["kind"].annotation))
    elif len(location) > 2:
        table, allowed = f"{table}.{location[1]}", Toleranced
    else:
        allowed = tables[table]
    names = list(allowed.model_fields)
    close = get_close_matches(key, names, n=1, cutoff=0.4)
    hint = f"did you mean {close[0]}?" if close else "remove it."
    place = f"[{table}] {key}" if table else key
    return f"{path}: {place} is not a key of a case; allowed are {', '.join(names)}; {hint}"


def _target_parts() -> tuple[type[BaseModel], ...]:
    """The models of all kinds of target."""
    return get_args(get_args(CaseTarget)[0])
