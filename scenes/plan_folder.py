"""What a plan's folder keeps beside its Program: its target and its figures."""

import json
from pathlib import Path
from typing import Any

from planner.errors import InputError
from planner.program import PROGRAM_FILE
from planner.target import Target, load_target
from scenes.planning import PLAN_FILE, TARGET_FILE


def plans_target(program: Path, digest: str | None) -> Target | None:
    """Return the target kept beside a plan's Program, None if there is none.

    Raises:
        InputError: if it is not the surface that the Program was planned for.
    """
    path = (program if program.is_dir() else program.parent) / TARGET_FILE
    if not path.is_file():
        return None
    target = load_target(path)
    if digest is not None and target.digest != digest:
        raise InputError(
            f"{path}: has the digest {target.digest[:19]}..., but {PROGRAM_FILE} was planned for {digest[:19]}...; "
            "plan again, or name the target to score against with --target."
        )
    return target


def plans_figures(program: Path, digest: str) -> dict[str, Any] | None:
    """Return the figures kept beside a plan's Program, None if there are none or they belong to another.

    Raises:
        InputError: if they cannot be read.
    """
    path = (program if program.is_dir() else program.parent) / PLAN_FILE
    if not path.is_file():
        return None
    try:
        figures = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise InputError(f"{path}: is no JSON ({error}); plan again, or move the file away.") from error
    return figures if isinstance(figures, dict) and figures.get("program_digest") == digest else None
