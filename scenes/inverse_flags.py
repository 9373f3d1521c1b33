"""The flags of inverse design, and the settings that they stand for.

No heavy library is imported before the settings are made, so that `lce --help` answers at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter
from cyclopts.validators import Number

from scenes.given_flags import given

if TYPE_CHECKING:
    from scenes.noise_flags import DesignNoiseFlags
    from scenes.predict_flags import DesignHeatingFlags, DesignMaterialFlags
    from twin.inverse import InverseOptions


@Parameter(name="*", group="Inverse design")
@dataclass(frozen=True, kw_only=True)
class InverseFlags:
    """What may be scratched and how long to search."""

    stack: Annotated[
        Literal["all", "pairs"] | None,
        Parameter(
            help="all: each layer has passes of its own. pairs: the lower layers share theirs, and the upper. "
            "Default: all."
        ),
    ] = None
    robust: Annotated[
        bool,
        Parameter(
            help="Lower what errors of the process, --noise-..., are expected to cost, for a little score without "
            "them and ten times the time."
        ),
    ] = False
    budget_s: Annotated[
        float | None,
        Parameter(
            help="Time to stop after, about [s]; 300 is a good one. Default: until it no longer pays.",
            validator=Number(gt=0, lte=86_400),
        ),
    ] = None
    resume: Annotated[bool, Parameter(help="Go on from what an interrupted search left in OUT.progress.")] = False


def inverse_options(
    inverse: InverseFlags,
    heating: DesignHeatingFlags,
    material: DesignMaterialFlags,
    noise: DesignNoiseFlags,
    *,
    layer_thickness_mm: tuple[float, ...],
    seed: int,
) -> InverseOptions:
    """Return the settings that the flags stand for.

    Raises:
        InputError: if a flag is out of range, or noise is given without a robust design to bear it.
    """
    from planner.errors import InputError
    from twin.inverse import InverseOptions
    from twin.predict import PredictOptions

    needless = given(noise)
    if needless and not inverse.robust:
        raise InputError(
            f"{', '.join(needless)}: says what a robust design must bear, but --robust is not given; add it, or leave "
            f"{'it' if len(needless) == 1 else 'them'} out."
        )
    heated = PredictOptions(
        material=material.material(),
        temperature_c=PredictOptions.temperature_c if heating.temperature_c is None else heating.temperature_c,
        support=heating.support,
    )
    heated.check()
    options = InverseOptions(
        layer_thickness_mm=layer_thickness_mm,
        stack=inverse.stack or "all",
        heated=heated,
        robust=inverse.robust,
        noise=noise.process_noise(),
        budget_s=inverse.budget_s,
        seed=seed,
    )
    options.check()
    return options
