"""The operations of a Program: what is done to each layer, in the words shared by planner, twin and rig."""

from itertools import pairwise
from math import hypot
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

Point = tuple[float, float]
"""x, y on the film [mm]."""


class Strict(BaseModel):
    """Base of all Program parts: frozen, unknown keys refused, no NaN or infinity."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Pass(Strict):
    """One stroke of the scratch post along a polyline, without lifting."""

    points_mm: Annotated[tuple[Point, ...], Field(min_length=2)]
    """Polyline on the film [mm]."""
    speed_mm_s: tuple[Annotated[float, Field(gt=0)], ...]
    """Speed on each segment [mm/s], one fewer than points."""
    load_g: tuple[Annotated[float, Field(gt=0)], ...]
    """Post load [g]: one value for the whole pass, or one for each point."""
    side: Literal["convex", "concave"]
    """Which way this pass bends the film: bottom layers convex, top layers concave."""

    @property
    def segment_lengths_mm(self) -> tuple[float, ...]:
        """Length of each segment [mm], one fewer than points."""
        return tuple(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(self.points_mm))

    @property
    def length_mm(self) -> float:
        """Length of the whole pass [mm]."""
        return sum(self.segment_lengths_mm)

    @property
    def scratch_s(self) -> float:
        """Time at the programmed speeds, without acceleration [s]."""
        lengths = zip(self.segment_lengths_mm, self.speed_mm_s, strict=True)
        return sum(length / speed for length, speed in lengths)


class Deposit(Strict):
    """Extrude or coat one layer of ink."""

    kind: Literal["deposit"] = "deposit"
    thickness_mm: Annotated[float, Field(gt=0)]


class ResetAlignment(Strict):
    """Heat the uncured layer with hot air until it is polydomain."""

    kind: Literal["reset_alignment"] = "reset_alignment"
    temperature_c: Annotated[float, Field(gt=0)] = 120.0
    duration_s: Annotated[float, Field(gt=0)] = 60.0


class Scratch(Strict):
    """Align the uncured layer along passes, in order."""

    kind: Literal["scratch"] = "scratch"
    passes: tuple[Pass, ...]


class Cure(Strict):
    """Crosslink the layer under UV light."""

    kind: Literal["cure"] = "cure"
    wavelength_nm: float = 365.0
    duration_s: Annotated[float, Field(gt=0)] = 180.0


class Cut(Strict):
    """Cut the finished film along a closed line (by hand, with scissors, in the paper)."""

    kind: Literal["cut"] = "cut"
    line_mm: Annotated[tuple[Point, ...], Field(min_length=3)]
    """Closed cut line on the film [mm], first point not repeated."""


class Actuate(Strict):
    """Heat the finished film on the hot plate and hold."""

    kind: Literal["actuate"] = "actuate"
    temperature_c: Annotated[float, Field(gt=0)] = 150.0
    hold_s: Annotated[float, Field(ge=0)] = 120.0


LayerOperation = Annotated[Deposit | ResetAlignment | Scratch | Cure, Field(discriminator="kind")]
FilmOperation = Annotated[Cut | Actuate, Field(discriminator="kind")]
