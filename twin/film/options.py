"""How a Program is turned into a film: mesh, post, fading, profile, and measured layers."""

from dataclasses import dataclass
from math import isfinite
from typing import Literal

from planner.errors import InputError
from planner.program import Machine

Profile = Literal["uniform", "skin"]

LEAST_LINE_WIDTH_MM = 0.2
"""Two pixels of the raster that passes are painted on."""


@dataclass(frozen=True, kw_only=True)
class FilmOptions:
    """How finely a film is meshed, how its passes are painted, and what its layers turned out to be."""

    mesh_mm: float = 0.6
    """Edge length of the triangles [mm]."""
    edge_blur_mm: float = 0.1
    """Standard deviation of the blur at the edges of a scratched line [mm]; an assumption, not measured."""
    line_width_mm: float | None = None
    """Width that one pass aligns [mm]; None for the Program's."""
    end_length_mm: float = 0.0
    """Way that the post moves at the start of each pass before it aligns [mm]."""
    profile: Profile = "uniform"
    """Alignment through the thickness of a layer: all of it a little, or a skin all the way; see `with_skin`."""
    fading_tau_h: float | None = None
    """Time after which 1/e of an uncured alignment is left [h], the paper's ink about 2.5; None or 0 for no fading."""
    machine: Machine | None = None
    """Machine whose speeds tell how long each pass waits for its cure; None for the paper's."""
    pass_to_cure_s: tuple[tuple[float, ...], ...] | None = None
    """Measured time from each pass to its layer's cure [s], which fading works on; None for the machine's model."""
    pass_strength: tuple[tuple[float, ...], ...] | None = None
    """Factor on the contraction of each pass, beside its load and speed; None for 1."""
    layer_thickness_mm: tuple[float, ...] | None = None
    """Measured thickness of each layer [mm], bottom first; None for the Program's."""
    modulus_ratio: tuple[float, ...] | None = None
    """Modulus of each layer over the material's, bottom first; None for 1."""

    def check(self, layer_count: int) -> None:
        """Refuse settings that make no film of so many layers; the mesh size is checked with the outline.

        Raises:
            InputError: with every problem found.
        """
        problems = []
        for name, value, example in (
            ("line width", self.line_width_mm, "0.8 mm is the paper's"),
            ("edge blur", self.edge_blur_mm, "the default is 0.1 mm"),
            ("end length", self.end_length_mm, "the default is 0 mm"),
            ("fading time", self.fading_tau_h, "2.5 h is the paper's ink"),
        ):
            least = LEAST_LINE_WIDTH_MM if name == "line width" else 0.0
            if value is not None and not (isfinite(value) and value >= least):
                problems.append(f"{name}: found {value:g}, allowed are finite values from {least:g}; {example}.")
        if self.profile not in ("uniform", "skin"):
            problems.append(f"profile: found {self.profile!r}, allowed are uniform and skin; choose one of them.")
        for name, values in (("layer thickness", self.layer_thickness_mm), ("modulus ratio", self.modulus_ratio)):
            if values is None:
                continue
            if len(values) != layer_count:
                problems.append(
                    f"{name}: found {len(values)} values, the Program has {layer_count} layers; give one value for "
                    "each, bottom first."
                )
            bad = [value for value in values if not (isfinite(value) and value > 0.0)]
            if bad:
                problems.append(f"{name}: found {bad[0]:g}, allowed are finite values above 0; correct it.")
        if problems:
            raise InputError(problems)
