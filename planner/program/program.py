"""The Program: everything that is done to make and actuate one film, in order."""

import hashlib
import json
from functools import cached_property
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from planner.errors import InputError
from planner.program.calibration_record import CalibrationRecord
from planner.program.operations import (
    Actuate,
    Cure,
    Cut,
    Deposit,
    FilmOperation,
    LayerOperation,
    Pass,
    Point,
    ResetAlignment,
    Scratch,
    Strict,
)
from planner.program.problems import program_problems

Positive = Annotated[float, Field(gt=0)]


class CreatedBy(Strict):
    """The software that wrote the Program."""

    name: str
    version: str


class Inputs(Strict):
    """What the Program was made from, enough to make it again."""

    method: str
    """How directions and curvatures were chosen: `perpendicular`, `maximum`, `inverse`, or another word."""
    target_name: str | None = None
    """None where the Program was written without a target."""
    target_sha256: Annotated[str, Field(pattern=r"^sha256:[0-9a-f]{64}$")] | None = None
    settings: dict[str, bool | int | float | str] = Field(default_factory=dict)
    """The planner's settings, flat."""


class Film(Strict):
    """The deposited sheet, before anything is cut away."""

    outline_mm: Annotated[tuple[Point, ...], Field(min_length=3)]
    """Deposited region [mm]: convex, counter-clockwise, first point not repeated (the paper: a rectangle)."""
    layer_thickness_mm: Annotated[tuple[Positive, ...], Field(min_length=1)]
    """Thickness of each layer [mm], bottom first."""
    line_width_mm: Positive = 0.8
    """Width that one pass aligns [mm]: the post's diameter."""
    uncut_margin_mm: Annotated[float, Field(ge=0)] = 0.0
    """Width of unaligned film left around the patterned region by the cut [mm]."""


class Layer(Strict):
    """One layer: deposit, reset, scratch (or not), cure."""

    index: Annotated[int, Field(ge=0)]
    """0 is the bottom layer, on the plate."""
    operations: tuple[LayerOperation, ...]
    """`deposit`, `reset_alignment`, `scratch` unless polydomain, `cure`, in this order."""

    @classmethod
    def of(cls, index: int, thickness_mm: float, passes: tuple[Pass, ...] = ()) -> Self:
        """Make a layer with the paper's temperatures and times; without passes it stays polydomain."""
        scratch = (Scratch(passes=passes),) if passes else ()
        deposit = Deposit(thickness_mm=thickness_mm)
        return cls(index=index, operations=(deposit, ResetAlignment(), *scratch, Cure()))

    @property
    def thickness_mm(self) -> float:
        """Thickness as deposited [mm]."""
        return sum(op.thickness_mm for op in self.operations if isinstance(op, Deposit))

    @property
    def passes(self) -> tuple[Pass, ...]:
        """The layer's passes in the order in which they are scratched; empty for a polydomain layer."""
        return tuple(stroke for op in self.operations if isinstance(op, Scratch) for stroke in op.passes)


class Program(Strict):
    """What to do, layer by layer, bottom first. It cannot be built with contradictions in it.

    Raises InputError with every problem found when parts contradict each other (see `program_problems`).
    """

    schema_version: Literal["1.0"] = "1.0"
    name: Annotated[str, Field(min_length=1)]
    seed: Annotated[int, Field(ge=0)]
    created_by: CreatedBy
    inputs: Inputs
    calibration: CalibrationRecord
    film: Film
    layers: Annotated[tuple[Layer, ...], Field(min_length=1)]
    finish: tuple[FilmOperation, ...]
    """`cut`, then `actuate`."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        problems = program_problems(self)
        if problems:
            raise InputError(problems)
        return self

    @property
    def cut(self) -> Cut:
        """The cut that gives the film its outline."""
        return next(op for op in self.finish if isinstance(op, Cut))

    @property
    def actuate(self) -> Actuate:
        """The heating on the plate."""
        return next(op for op in self.finish if isinstance(op, Actuate))

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the Program as canonical JSON: keys sorted, no spaces, shortest exact floats, UTF-8."""
        text = json.dumps(self.model_dump(mode="json"), sort_keys=True, separators=(",", ":"), ensure_ascii=False)
        return "sha256:" + hashlib.sha256(text.encode()).hexdigest()
