"""The flags of the process's noise, and what they stand for.

No heavy library is imported before it is asked for, so that `lce --help` answers at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import radians
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

from scenes.given_flags import given

if TYPE_CHECKING:
    from twin.batch import ProcessNoise


GROUP = "Noise"


@Parameter(name="*", group=GROUP)
@dataclass(frozen=True, kw_only=True)
class DesignNoiseFlags:
    """How far the process strays."""

    noise_strain: Annotated[
        float, Parameter(help="Relative error of the contraction of the whole film, 0 to 0.3 (standard deviation).")
    ] = 0.05
    noise_layer_strain: Annotated[
        float, Parameter(help="Relative error of the contraction of each layer, 0 to 0.3 (standard deviation).")
    ] = 0.05
    noise_direction_deg: Annotated[
        float, Parameter(help="Error of the direction of alignment [deg] (standard deviation).")
    ] = 5.0
    noise_direction_length_mm: Annotated[
        float,
        Parameter(
            help="Way over which that error changes [mm]; inf turns each layer as a whole. A search for a robust plan "
            "takes 10 at least."
        ),
    ] = 0.8
    noise_registration_mm: Annotated[
        float, Parameter(help="Shift of each layer along x, and along y [mm] (standard deviation).")
    ] = 0.2

    def process_noise(self) -> ProcessNoise:
        """Return the noise.

        Raises:
            InputError: if a number is out of range.
        """
        from twin.batch import ProcessNoise

        noise = ProcessNoise(
            strain=self.noise_strain,
            layer_strain=self.noise_layer_strain,
            direction_rad=radians(self.noise_direction_deg),
            direction_length_mm=self.noise_direction_length_mm,
            registration_mm=self.noise_registration_mm,
        )
        noise.check()
        return noise


@Parameter(name="*", group=GROUP)
@dataclass(frozen=True, kw_only=True)
class NoiseFlags(DesignNoiseFlags):
    """The same, and how many films show it."""

    noise: Annotated[
        int,
        Parameter(
            help="Heat this many films, each with errors of the process of its own, and tell how their scores spread; "
            "32 are a good number. Default: none.",
            validator=Number(gte=0, lte=1000),
        ),
    ] = 0
    noise_mesh_mm: Annotated[
        float,
        Parameter(
            help="Edge of those films' triangles [mm], unless --mesh-mm is longer: shorter ones take longer, "
            "and the prediction's own makes scores comparable with its.",
            validator=Number(gte=0.05, lte=5.0),
        ),
    ] = 0.8

    def process_noise(self) -> ProcessNoise:
        """Return the noise.

        Raises:
            InputError: if a number is out of range, or given without films to show it.
        """
        from planner.errors import InputError

        needless = given(self)
        if needless and not self.noise:
            raise InputError(
                f"{', '.join(needless)}: says how noisy films are, but --noise, their number, is 0; give "
                "--noise 32, or leave it out."
            )
        return super().process_noise()
