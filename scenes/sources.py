"""What a user may call a target on the command line: a built-in case, a case file, or a surface in a file."""

import re
from dataclasses import replace
from pathlib import Path

from planner.errors import InputError
from planner.program import PROGRAM_FILE
from planner.program.as_run import AS_RUN_FILE
from planner.program.as_run_film import AsRunFilm, load_as_run
from planner.target import TARGET_SUFFIXES, Target, load_target
from scenes.case import Case, load_case
from twin.film import FilmOptions
from twin.temperature import TemperatureField, TemperatureGapModel, TemperatureUniform, load_temperature_file

STEEPEST = 3.0
"""Depth over the larger side seen from above that a target may have: a flat film reaches no tower, and sampling
one takes time and memory that grow with its walls."""


def open_source(
    text: str, *, size_mm: str | None = None, up: str = "+z", depth_mm: float | None = None
) -> tuple[Target, Case | None]:
    """Return the target that `text` names, and the case that it belongs to, if any.

    Args:
        text: name of a built-in case, a case file (.toml), or a surface file.
        size_mm: box to scale a file's surface into, as `40x60` [mm].
        up: axis of the file that points up.
        depth_mm: height that white stands for in a grey image [mm].

    Raises:
        InputError: if there is no such target, an option does not fit it, or it is a tower.
    """
    path = Path(text)
    if path.suffix.lower() in TARGET_SUFFIXES or path.is_dir():
        return _checked(load_target(path, size_mm=parse_size(size_mm), up=up, depth_mm=depth_mm)), None
    if path.suffix and path.suffix != ".toml":
        allowed = ", ".join((*TARGET_SUFFIXES, ".toml"))
        raise InputError(f"target: {text} ends in {path.suffix!r}, allowed are {allowed}, or a scene of `lce scenes`.")
    case = load_case(text)
    given = {"--size-mm": size_mm, "--depth-mm": depth_mm, "--up": None if up == "+z" else up}
    wrong = [f"{flag} {value}" for flag, value in given.items() if value is not None]
    if wrong:
        raise InputError(
            f"target: {', '.join(wrong)} is for surface files, but {text} is a case with its own size; "
            "leave it out, or copy the case's file and change its [target] table."
        )
    return _checked(case.make_target()), case


def _checked(target: Target) -> Target:
    """Return the target if a film could become it."""
    side = max(target.size_mm)
    if target.depth_mm > STEEPEST * side:
        raise InputError(
            f"target: {target.name} is {target.depth_mm:.3g} mm deep and at most {side:.3g} mm wide, allowed is a "
            f"depth up to {STEEPEST:g} times the width; check its units, its up direction (--up) or its depth "
            "(--depth-mm)."
        )
    return target


def open_as_run(path: Path) -> AsRunFilm | None:
    """Return the film of an as-run log, if that is what a path names: such a file, or a run's folder.

    Raises:
        InputError: if the log cannot be read, or the run is not finished.
    """
    if path.is_dir() and not (path / PROGRAM_FILE).exists() and (path / AS_RUN_FILE).exists():
        path = path / AS_RUN_FILE
    return load_as_run(path) if path.suffix == ".jsonl" else None


def as_it_was_run(film: FilmOptions, made: AsRunFilm) -> FilmOptions:
    """Return options of a film with what was measured while it was made."""
    return replace(film, pass_to_cure_s=made.pass_to_cure_s, pass_strength=made.pass_strength)


def parse_size(text: str | None) -> tuple[float, float] | None:
    """Return (width, height) of a box written as `40x60` [mm].

    Raises:
        InputError: if it is written otherwise.
    """
    if text is None:
        return None
    match = re.fullmatch(r"\s*([0-9.]+)\s*[xX*]\s*([0-9.]+)\s*(mm)?\s*", text)
    try:
        width, height = (float(part) for part in match.group(1, 2)) if match else (0.0, 0.0)
    except ValueError:
        width, height = 0.0, 0.0
    if width <= 0.0 or height <= 0.0:
        raise InputError(f"--size-mm: found {text!r}, allowed is width x height in mm; write for example 40x60.")
    return width, height


def open_temperature_field(text: str) -> TemperatureField:
    """Return the temperature field that `text` names: `uniform`, `gap_model`, or a file of measured temperatures.

    Raises:
        InputError: if it is none of them, or the file is wrong.
    """
    if text == "uniform":
        return TemperatureUniform()
    if text == "gap_model":
        return TemperatureGapModel()
    if text.endswith(".npz"):
        return load_temperature_file(Path(text))
    raise InputError(
        f"--temperature-field: found {text!r}, allowed are uniform, gap_model or an .npz file; the default is uniform."
    )


def parse_numbers(flag: str, text: str, example: str) -> tuple[float, ...]:
    """Return the numbers of a flag written with commas between, as `0.2,0.2,0.2,0.2`.

    Raises:
        InputError: if it is written otherwise.
    """
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise InputError(
            f"{flag}: found {text!r}, allowed are numbers with commas between; write for example {example}."
        ) from None


def parse_layers(text: str) -> tuple[float, ...]:
    """Return layer thicknesses written as `0.2,0.2,0.2,0.2` [mm], bottom first.

    Raises:
        InputError: if it is written otherwise.
    """
    return parse_numbers("--layers-mm", text, "0.2,0.2,0.2,0.2")
