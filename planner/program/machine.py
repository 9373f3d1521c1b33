"""What a machine can do: the numbers that checks, times and simulations of a Program need."""

from pathlib import Path
from typing import Annotated, Self

from pydantic import Field, model_validator

from planner.program.operations import Strict
from planner.program.toml_file import read_toml

PAPER_MACHINE = Path(__file__).with_name("paper_machine.toml")

Positive = Annotated[float, Field(gt=0)]
Range = tuple[float, float]


class Stage(Strict):
    """The three-axis stage that carries the post."""

    x_mm: Range
    """Reach of the post's centre in the film frame [mm]."""
    y_mm: Range
    scratch_speed_mm_s: tuple[Positive, Positive]
    """Slowest and fastest speed at which the post scratches reliably [mm/s]."""
    travel_speed_mm_s: Positive
    acceleration_mm_s2: Positive
    lift_mm: Positive
    """Clearance of the post over the film between passes [mm]."""
    lift_speed_mm_s: Positive
    lift_max_mm: Positive

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        for name in ("x_mm", "y_mm", "scratch_speed_mm_s"):
            low, high = getattr(self, name)
            if not low < high:
                raise ValueError(f"{name} is [{low:g}, {high:g}], allowed is [low, high]")
        if self.lift_mm > self.lift_max_mm:
            raise ValueError(f"lift_mm is {self.lift_mm:g}, allowed is at most lift_max_mm = {self.lift_max_mm:g}")
        return self


class Pump(Strict):
    """The syringe pump that sets the load by moving water."""

    rate_ml_min: Positive
    ml_per_g: Positive
    syringe_ml: Positive
    load_g_max: Positive

    def change_s(self, load_g: float) -> float:
        """Return the time to change the load by so many grams, up or down [s]."""
        return abs(load_g) * self.ml_per_g / self.rate_ml_min * 60


class Heat(Strict):
    """Hot air, hot plate and UV lamp."""

    hot_air_c_max: float
    hot_plate_c_max: float
    lamp_wavelength_nm: Positive


class LayerLimits(Strict):
    """How long the scratching of one layer may take before the first passes fade."""

    budget_s: Positive
    """Planned time for scratching one layer [s]."""
    alignment_life_s: Positive
    """Time after which the alignment of the uncured ink is gone [s]."""


class Machine(Strict):
    """A machine, as described in a TOML file."""

    name: Annotated[str, Field(min_length=1)]
    stage: Stage
    pump: Pump
    heat: Heat
    layer: LayerLimits


def load_machine(path: str | Path | None = None) -> Machine:
    """Read a machine from a TOML file; without a path the paper's machine.

    Raises InputError with every problem found: unreadable file, unknown or missing key, wrong value.
    """
    return read_toml(PAPER_MACHINE if path is None else Path(path), Machine, "machine")
