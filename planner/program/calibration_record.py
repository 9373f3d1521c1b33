"""The calibration that a Program was planned with, carried along as a full snapshot."""

from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from planner.program.operations import Strict

Positive = Annotated[float, Field(gt=0)]
Grid = tuple[tuple[float, ...], ...]
"""One row for each load, one value in it for each speed."""


def _absent(value: object) -> bool:
    """Whether a field is left out of files and digests, which so stay those of records that never had it."""
    return value is None


class CalibrationLimits(Strict):
    """The range inside which the calibration was measured; settings outside it are refused."""

    load_g_min: Positive
    load_g_max: Positive
    speed_mm_s_min: Positive
    speed_mm_s_max: Positive
    radius_mm_min: Positive
    radius_mm_max: Positive

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        for name in ("load_g", "speed_mm_s", "radius_mm"):
            low, high = getattr(self, f"{name}_min"), getattr(self, f"{name}_max")
            if not low < high:
                raise ValueError(f"{name}_min is {low:g} and must be smaller than {name}_max, which is {high:g}")
        return self


class CalibrationStrip(Strict):
    """The strip whose bending radius was measured: it ties a radius to a contraction."""

    layer_thickness_mm: Annotated[tuple[Positive, ...], Field(min_length=2)] = (0.2, 0.2, 0.2, 0.2)
    """Layer thicknesses [mm], bottom first."""
    aligned_layers: Annotated[tuple[Annotated[int, Field(ge=0)], ...], Field(min_length=1)] = (0, 1)
    """Indices of the scratched layers; the others are polydomain."""
    width_mm: Annotated[Positive | None, Field(exclude_if=_absent)] = None
    """Width of the strip [mm]: a narrow one bends up to 4/3 as much as a wide one. None for wide."""

    @model_validator(mode="after")
    def _can_bend(self) -> Self:
        count = len(self.layer_thickness_mm)
        aligned = set(self.aligned_layers)
        if len(aligned) < len(self.aligned_layers) or max(aligned) >= count or len(aligned) == count:
            raise ValueError(
                f"aligned_layers is {list(self.aligned_layers)}, allowed are some but not all of the "
                f"layers 0 to {count - 1}, each once"
            )
        return self


class SaturatingModel(Strict):
    """Alignment that saturates with load and falls with speed as a power.

    s(v, F) = (1 - exp(-F / F0)) / (1 - exp(-F_max / F0)) (v / v_min)^-p and contraction = s e(R_min), where
    e(R) is the contraction that bends the calibration strip to R; F_max, v_min, R_min are the calibration's
    limits.
    """

    kind: Literal["saturating"] = "saturating"
    load_scale_g: Positive
    """F0, the load at which alignment approaches saturation [g]."""
    speed_exponent: Positive
    """p, dimensionless."""


class TableModel(Strict):
    """Measured bending radii on a grid of loads and speeds."""

    kind: Literal["table"] = "table"
    load_g: Annotated[tuple[Positive, ...], Field(min_length=2)]
    """Loads [g], ascending, shape [m]."""
    speed_mm_s: Annotated[tuple[Positive, ...], Field(min_length=2)]
    """Speeds [mm/s], ascending, shape [n]."""
    radius_mm: tuple[tuple[Positive, ...], ...]
    """Bending radii [mm], one row for each load, shape [m][n]; fall with load and rise with speed."""

    @model_validator(mode="after")
    def _monotone(self) -> Self:
        rows, columns = self.radius_mm, tuple(zip(*self.radius_mm, strict=False))
        if len(rows) != len(self.load_g) or any(len(row) != len(self.speed_mm_s) for row in rows):
            raise ValueError("radius_mm must have one row for each load and in it one value for each speed")
        if not (_ascending(self.load_g) and _ascending(self.speed_mm_s)):
            raise ValueError("load_g and speed_mm_s must be ascending")
        if not (all(map(_ascending, rows)) and all(_ascending(column[::-1]) for column in columns)):
            raise ValueError("radius_mm must rise with speed and fall with load, else no setting can be chosen")
        return self


def _ascending(values: tuple[float, ...]) -> bool:
    return all(a < b for a, b in pairwise(values))


class CalibrationUncertainty(Strict):
    """How well the map of a `table` is known, in the logarithm of the radius, on the table's own grid.

    A map drawn from what the strips leave open is radius_mm exp(sum over k of z_k modes[k]) with independent standard
    normal z_k: the errors of settings near each other go together.
    """

    level: Annotated[float, Field(gt=0, lt=1)]
    """Probability that the whole map lies inside the band, at all loads and speeds at once."""
    band_log_radius: Grid
    """Half width of that band, shape [m][n]: the map lies between radius_mm exp(-band) and radius_mm exp(band)."""
    modes_log_radius: Annotated[tuple[Grid, ...], Field(min_length=1)]
    """Modes of a drawn map, shape [k][m][n]."""
    strip_log_radius: Annotated[float, Field(ge=0)]
    """Standard deviation of one strip about the map: it tells about films, but is no part of the band."""


CalibrationModel = Annotated[SaturatingModel | TableModel, Field(discriminator="kind")]


class CalibrationRecord(Strict):
    """(load, speed) <-> bending radius, with what is known about where it comes from."""

    name: Annotated[str, Field(min_length=1)]
    placeholder: bool
    """True where the values are not measured; every output that depends on it says so."""
    provenance: dict[str, str]
    """Where the values come from: source, date, operator, method, strip width, number of samples."""
    limits: CalibrationLimits
    strip: CalibrationStrip = CalibrationStrip()
    model: CalibrationModel
    uncertainty: Annotated[CalibrationUncertainty | None, Field(exclude_if=_absent)] = None
    """None where it is not known."""

    @model_validator(mode="after")
    def _uncertainty_on_the_grid(self) -> Self:
        if self.uncertainty is None:
            return self
        if not isinstance(self.model, TableModel):
            raise ValueError(f"uncertainty is for a model of kind 'table', found '{self.model.kind}'")
        shape = (len(self.model.load_g), len(self.model.speed_mm_s))
        for grid in (self.uncertainty.band_log_radius, *self.uncertainty.modes_log_radius):
            if len(grid) != shape[0] or any(len(row) != shape[1] for row in grid):
                raise ValueError(f"uncertainty must have {shape[0]} rows of {shape[1]} values, as model.radius_mm has")
        if any(value < 0 for row in self.uncertainty.band_log_radius for value in row):
            raise ValueError("uncertainty.band_log_radius must not be negative")
        return self

    @model_validator(mode="after")
    def _table_covers_limits(self) -> Self:
        if isinstance(self.model, TableModel):
            limits = self.limits
            for name, values in (("load_g", self.model.load_g), ("speed_mm_s", self.model.speed_mm_s)):
                low, high = getattr(limits, f"{name}_min"), getattr(limits, f"{name}_max")
                if values[0] > low or values[-1] < high:
                    raise ValueError(
                        f"model.{name} spans {values[0]:g} to {values[-1]:g} and must cover the limits "
                        f"{low:g} to {high:g}"
                    )
        return self
