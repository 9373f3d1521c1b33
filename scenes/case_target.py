"""The `[target]` table of a case file: a kind of parametric target and its lengths."""

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from planner.target import Target
from scenes import targets

Positive = Annotated[float, Field(gt=0, le=300)]
"""Lengths [mm]; the largest film is 300 mm."""
Below1 = Annotated[float, Field(gt=0, lt=1)]


class CasePart(BaseModel):
    """A table of a case file: frozen, no unknown keys, no NaN or infinity."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Dome(CasePart):
    """Half an ellipsoid of revolution, oblate or prolate, cut by an upright cylinder."""

    kind: Literal["dome"]
    radius_mm: Positive
    height_mm: Positive
    cut: Below1

    def make(self) -> Target:
        """Make the target."""
        return targets.ellipsoid_dome(radius_mm=self.radius_mm, height_mm=self.height_mm, cut=self.cut)


class SphereCap(CasePart):
    """The cap of a sphere."""

    kind: Literal["sphere_cap"]
    radius_mm: Positive
    edge_radius_mm: Positive

    @model_validator(mode="after")
    def _within(self) -> Self:
        if self.edge_radius_mm >= self.radius_mm:
            raise ValueError(
                f"edge_radius_mm is {self.edge_radius_mm:g} and must be smaller than radius_mm, {self.radius_mm:g}"
            )
        return self

    def make(self) -> Target:
        """Make the target."""
        return targets.sphere_cap(radius_mm=self.radius_mm, edge_radius_mm=self.edge_radius_mm)


class Saddle(CasePart):
    """A saddle, convex along x and concave along y."""

    kind: Literal["saddle"]
    radius_mm: Positive
    edge_radius_mm: Positive

    def make(self) -> Target:
        """Make the target."""
        return targets.saddle(radius_mm=self.radius_mm, edge_radius_mm=self.edge_radius_mm)


class Ridge(CasePart):
    """A cylinder's back along y with soft ends."""

    kind: Literal["ridge"]
    radius_mm: Positive
    width_mm: Positive
    length_mm: Positive
    end_mm: Positive

    @model_validator(mode="after")
    def _within(self) -> Self:
        if self.width_mm >= 2 * self.radius_mm:
            raise ValueError(
                f"width_mm is {self.width_mm:g} and must be smaller than twice radius_mm, {2 * self.radius_mm:g}"
            )
        return self

    def make(self) -> Target:
        """Make the target."""
        return targets.ridge(
            radius_mm=self.radius_mm, width_mm=self.width_mm, length_mm=self.length_mm, end_mm=self.end_mm
        )


class TwoBump(CasePart):
    """A dome and a hollow side by side."""

    kind: Literal["two_bump"]
    width_mm: Positive
    height_mm: Positive
    bump_mm: Positive
    spread_mm: Positive

    def make(self) -> Target:
        """Make the target."""
        return targets.two_bump(
            width_mm=self.width_mm,
            height_mm=self.height_mm,
            bump_mm=self.bump_mm,
            spread_mm=self.spread_mm,
        )


class Face(CasePart):
    """The parametric face."""

    kind: Literal["face"]
    width_mm: Positive
    height_mm: Positive

    def make(self) -> Target:
        """Make the target."""
        return targets.face(width_mm=self.width_mm, height_mm=self.height_mm)


class Strip(CasePart):
    """A calibration strip, given by its bending radius or by its layers' contraction."""

    kind: Literal["strip"]
    length_mm: Positive
    width_mm: Positive
    radius_mm: Positive | None = None
    contraction: Annotated[float, Field(gt=0, le=0.6)] | None = None
    """Contraction of the bottom two of four layers of 0.2 mm; it bends a wide strip to `bending_radius_mm`."""

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        if (self.radius_mm is None) == (self.contraction is None):
            raise ValueError("a strip takes exactly one of radius_mm and contraction")
        return self

    @property
    def bending_radius_mm(self) -> float:
        """The bending radius [mm], calculated for a wide strip where the contraction is given."""
        if self.radius_mm is not None:
            return self.radius_mm
        # The spline tables behind this are slow to import; listing cases needs none of them.
        from planner.calibration import radius_for_contraction

        return float(radius_for_contraction(self.contraction or 0.0, (0.2,) * 4, (0, 1)))

    def make(self) -> Target:
        """Make the target."""
        return targets.strip(length_mm=self.length_mm, width_mm=self.width_mm, radius_mm=self.bending_radius_mm)


CaseTarget = Annotated[Dome | SphereCap | Saddle | Ridge | TwoBump | Face | Strip, Field(discriminator="kind")]
