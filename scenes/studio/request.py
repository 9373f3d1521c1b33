"""What is asked of a job, and the command lines that do it."""

import sys
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from planner.errors import InputError

PLAN, HOT = "plan", "hot"
"""The folders of the results inside a job's, each written by one command."""
STEPS = {PLAN: "Plan", HOT: "Predict"}
LONGEST = 200
"""Characters in a text field: enough for any list of numbers."""


def _empty_is_none(value: Any) -> Any:
    """Take a field of the page that was left empty for one that was not given."""
    return None if value == "" else value


EmptyIsNone = BeforeValidator(_empty_is_none)
Text = Annotated[Annotated[str, Field(max_length=LONGEST)] | None, EmptyIsNone]
Scene = Annotated[Annotated[str, Field(pattern=r"^[a-z0-9_]+$")] | None, EmptyIsNone]
Upload = Annotated[Annotated[str, Field(pattern=r"^uploads/[0-9a-f]{16}/[A-Za-z0-9_-]+\.[a-z]+$")] | None, EmptyIsNone]
"""Of uploaded files only: no page may name any other file of this machine."""
Number = Annotated[Annotated[float, Field(allow_inf_nan=False)] | None, EmptyIsNone]
Whole = Annotated[int | None, EmptyIsNone]


class JobRequest(BaseModel):
    """A target, a method and the options that were changed; whatever is None is left to the commands."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    scene: Scene = None
    """Built-in scene, or None for the uploaded file."""
    upload: Upload = None
    """Path of the uploaded file inside the workspace."""
    size_mm: Text = None
    up: Literal["+x", "-x", "+y", "-y", "+z", "-z"] = "+z"
    depth_mm: Number = None
    method: Literal["perpendicular", "maximum", "inverse"] = "perpendicular"
    tracer: Annotated[Literal["greedy", "dense"] | None, EmptyIsNone] = None
    flattening: Annotated[Literal["arap", "grid"] | None, EmptyIsNone] = None
    margin_mm: Number = None
    layers_mm: Text = None
    seed: Whole = None
    calibration: Upload = None
    """Path of an uploaded calibration inside the workspace."""
    stack: Annotated[Literal["all", "pairs"] | None, EmptyIsNone] = None
    robust: bool = False
    budget_s: Number = None
    temperature_c: Number = None
    support: Annotated[Literal["plate", "free"] | None, EmptyIsNone] = None
    modulus_mpa: Number = None
    mesh_mm: Number = None

    @property
    def target_name(self) -> str:
        """Name of the target as a user knows it."""
        return self.scene or Path(self.upload or "").stem

    @property
    def title(self) -> str:
        """A few words that tell this request from others."""
        parts = [self.target_name, self.method]
        parts += [] if self.size_mm is None else [f"{self.size_mm} mm"]
        return ", ".join(parts)

    @property
    def options(self) -> str:
        """The other options that were given, for people."""
        told = {"scene", "upload", "size_mm", "method"}
        given = self.model_dump(exclude_defaults=True, exclude=told)
        return ", ".join(f"{name} {_word(name, value)}" for name, value in given.items())

    def source(self, workspace: Path) -> str:
        """Return what the command line calls the target.

        Raises:
            InputError: if none was chosen.
        """
        if self.scene:
            return self.scene
        if self.upload:
            return str(workspace / self.upload)
        raise InputError("target: none is chosen; choose a built-in scene or open a file.")

    @property
    def shape_options(self) -> dict[str, Any]:
        """What decides the surface of a file beside the file, as `open_source` takes it; a scene has its own size."""
        if not self.upload:
            return {}
        return {"size_mm": self.size_mm, "up": self.up, "depth_mm": self.depth_mm}

    def commands(self, workspace: Path, folder: Path) -> dict[str, list[str]]:
        """Return the arguments of `lce` for each step, by the name of the folder that it writes.

        Args:
            workspace: folder that the uploaded files lie in.
            folder: folder of the job.

        Raises:
            InputError: if no target was chosen.
        """
        plan, hot = (str(folder / name) for name in (PLAN, HOT))
        inverse = self.method == "inverse"
        heated = _flags({"--temperature-c": self.temperature_c, "--support": self.support})
        heated += _flags({"--modulus-mpa": self.modulus_mpa})
        planned = {
            **{f"--{name.replace('_', '-')}": value for name, value in self.shape_options.items()},
            "--method": self.method,
            "--tracer": None if inverse else self.tracer,
            "--flattening": None if inverse else self.flattening,
            "--margin-mm": None if inverse else self.margin_mm,
            "--layers-mm": self.layers_mm,
            "--seed": self.seed,
            "--calibration": None if self.calibration is None else str(workspace / self.calibration),
            "--stack": self.stack if inverse else None,
            "--budget-s": self.budget_s if inverse else None,
        }
        searched = [*(["--robust"] if self.robust else []), *heated] if inverse else []
        return {
            PLAN: ["plan", self.source(workspace), "--out", plan, *_flags(planned), *searched],
            HOT: ["predict", plan, "--out", hot, *_flags({"--mesh-mm": self.mesh_mm}), *heated],
        }


def _word(name: str, value: Any) -> str:
    """Return the value of an option for people."""
    if name == "calibration":
        return Path(value).stem
    return f"{value:g}" if isinstance(value, float) else str(value)


def _flags(values: dict[str, Any]) -> list[str]:
    """Return flags with their values, without those that are None; `=` lets no value pass for a flag."""
    return [f"{flag}={value}" for flag, value in values.items() if value is not None]


def read_request(values: dict[str, Any]) -> JobRequest:
    """Return the request that the fields of the page make.

    Raises:
        InputError: naming each field that is wrong.
    """
    try:
        return JobRequest.model_validate(values)
    except ValidationError as error:
        raise InputError(
            [
                f"{'.'.join(str(part) for part in found['loc'])}: found {found['input']!r}, {found['msg']}; correct it."
                for found in error.errors()
            ]
        ) from error


def command_line(arguments: list[str]) -> list[str]:
    """Return what to execute for `lce` with these arguments, in this very Python."""
    return [sys.executable, "-m", "scenes.cli", *arguments]
