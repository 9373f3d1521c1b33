"""The `[expected]` table of a case file: what the twin is known to predict for it, for the tests of fidelity."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from scenes.case_target import CasePart, Positive

Form = Literal["dome", "bowl", "saddle"]
"""Both principal curvatures convex seen from above, both concave, or one of each."""


class Toleranced(CasePart):
    """A number and how far a prediction may lie from it, both in the unit of the key's name."""

    value: float
    tolerance: Positive


class Expected(CasePart):
    """What planning and predicting the case by its own settings, but at `mesh_mm`, is known to give."""

    mesh_mm: Annotated[float, Field(gt=0)]
    """Edge length of the film's triangles that the numbers were found at [mm]: coarse, so that tests are fast."""
    ssim_eq4: Toleranced | None = None
    rms_mm: Toleranced | None = None
    bending_radius_mm: Toleranced | None = None
    """Of a strip, in its middle [mm]."""
    form: dict[Literal["perpendicular", "maximum"], Form] = Field(default_factory=dict)
    """The film's form as a whole for plans by these methods."""

    @model_validator(mode="after")
    def _says_something(self) -> Self:
        if not self.numbers and not self.form:
            raise ValueError("expected takes at least one of ssim_eq4, rms_mm, bending_radius_mm and form")
        return self

    @property
    def numbers(self) -> dict[str, Toleranced]:
        """The numbers that are given, by name."""
        names = ("ssim_eq4", "rms_mm", "bending_radius_mm")
        return {name: number for name in names if (number := getattr(self, name)) is not None}
