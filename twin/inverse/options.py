"""Settings of an inverse design."""

from dataclasses import dataclass, field

from planner.errors import InputError
from planner.plan import LAYER_THICKNESS_MM
from twin.batch import ProcessNoise
from twin.inverse.field_control import Stack
from twin.predict import PredictOptions
from twin.temperature import TemperatureUniform

LEAST_TRIANGLES = 100


@dataclass(frozen=True, kw_only=True)
class InverseOptions:
    """What may be scratched, how the film will be heated, and how long to search."""

    layer_thickness_mm: tuple[float, ...] = LAYER_THICKNESS_MM
    """Flat thickness of each layer [mm], bottom first."""
    stack: Stack = "all"
    """`all`: every layer has a field of its own; `pairs`: the lower half of the layers share one and the upper half."""
    heated: PredictOptions = field(default_factory=PredictOptions)
    """How the film will be heated: weight, plate, temperature, and the mesh of the final check."""
    line_width_mm: float = 0.8
    """Width that one pass aligns [mm]."""
    coarse_triangles: int = 1600
    """Size of the first mesh, on which the basin is chosen."""
    middle_triangles: int = 5000
    """Size of the mesh of the smooth fields."""
    pass_triangles: int = 10_000
    """Size of the mesh on which the passes are optimised."""
    robust: bool = False
    """Whether what noise is expected to cost is lowered too, for a little score without it and ten times the time."""
    noise: ProcessNoise = field(default_factory=ProcessNoise)
    """Standard deviations of the errors that a robust design is made for; what it is searched for follows from them,
    see `twin.inverse.noise.searched`: directions over less than 10 mm count as if over 10 mm."""
    budget_s: float | None = None
    """Time to stop after [s], about; None to go on until it no longer pays."""
    seed: int = 0

    def check(self) -> None:
        """Refuse settings that make no design.

        Raises:
            InputError: with every problem found.
        """
        problems = []
        if self.stack not in ("all", "pairs"):
            problems.append(f"stack: found {self.stack!r}, allowed are all and pairs; choose one of them.")
        if len(self.layer_thickness_mm) < 2 or any(not value > 0.0 for value in self.layer_thickness_mm):
            problems.append(
                f"layer thickness: found {list(self.layer_thickness_mm)}, allowed are two or more positive lengths in "
                "mm; the paper's film has 0.2, 0.2, 0.2, 0.2."
            )
        if self.budget_s is not None and not self.budget_s > 0.0:
            problems.append(f"budget: found {self.budget_s:g} s, allowed is a positive time; 300 s is a good one.")
        for name in ("coarse", "middle", "pass"):
            count = getattr(self, f"{name}_triangles")
            if count < LEAST_TRIANGLES:
                problems.append(
                    f"{name} triangles: found {count}, allowed are {LEAST_TRIANGLES} and more; leave it at the default."
                )
        if self.seed < 0:
            problems.append(f"seed: found {self.seed}, allowed is a whole number from 0; choose another.")
        if not isinstance(self.heated.temperature_field, TemperatureUniform):
            problems.append(
                "temperature field: the inverse method designs for a uniform one; plan so, then predict the Program "
                f"in the field '{self.heated.temperature_field.kind}'."
            )
        if problems:
            raise InputError(problems)
