"""The flags of the film's heating, in the groups that help shows, and the settings that they stand for.

Those that the inverse method asks for, too, come first: it designs for the film as it will be heated.

No heavy library is imported before the settings are made, so that `lce --help` answers at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter
from cyclopts.validators import Number

if TYPE_CHECKING:
    from twin.film import FilmOptions
    from twin.material import Material
    from twin.predict import PredictOptions

HEATING, MATERIAL, POST, SOLVER = "Heating", "Material and layers", "Post", "Solver"


@Parameter(name="*", group=HEATING)
@dataclass(frozen=True, kw_only=True)
class DesignHeatingFlags:
    """What the film is designed for."""

    temperature_c: Annotated[
        float | None, Parameter(help="Temperature to heat to, 25 to 200 [C]. Default: 150, the paper's.")
    ] = None
    support: Annotated[
        Literal["plate", "free"],
        Parameter(help="plate: lying on the hot plate under its own weight. free: weightless, touching nothing."),
    ] = "plate"


@Parameter(name="*", group=HEATING)
@dataclass(frozen=True, kw_only=True)
class HeatingFlags(DesignHeatingFlags):
    """What is done to the film."""

    temperatures_c: Annotated[
        str | None,
        Parameter(
            help="Temperatures to pass through instead, up and down, as 25,60,90,150,90,25 [C]: the shape at each is "
            "kept, that at the highest is scored."
        ),
    ] = None
    cool: Annotated[bool, Parameter(help="Cool to 25 C in the end, and say whether the film comes back flat.")] = False
    temperature_field: Annotated[
        str, Parameter(help="uniform; gap_model: parts lifted off the plate are colder; or a measured field (.npz).")
    ] = "uniform"
    tap_mm: Annotated[
        float,
        Parameter(
            help="How far a film that only its weight holds flat is lifted to see whether it jumps, 0 for not [mm].",
            validator=Number(gte=0, lte=10),
        ),
    ] = 0.4


@Parameter(name="*", group=MATERIAL)
@dataclass(frozen=True, kw_only=True)
class DesignMaterialFlags:
    """What any film is made of."""

    modulus_mpa: Annotated[
        float,
        Parameter(help="Young's modulus of the hot film, 0.01 to 100 [MPa].", validator=Number(gte=0.01, lte=100)),
    ] = 0.5
    density_kg_m3: Annotated[
        float, Parameter(help="Density, up to 10000 [kg/m3].", validator=Number(gte=0, lte=10_000))
    ] = 1200.0
    transition_c: Annotated[
        float, Parameter(help="Nematic-isotropic temperature: shifts contraction over temperature [C].")
    ] = 85.0

    def material(self) -> Material:
        """Return the material.

        Raises:
            InputError: if a constant is out of range.
        """
        from twin.material import Material

        return Material(modulus_mpa=self.modulus_mpa, density_kg_m3=self.density_kg_m3, transition_c=self.transition_c)


@Parameter(name="*", group=MATERIAL)
@dataclass(frozen=True, kw_only=True)
class MaterialFlags(DesignMaterialFlags):
    """What this film is made of."""

    layers_mm: Annotated[
        str | None,
        Parameter(help="Measured thickness of each layer, bottom first, as 0.2,0.2,0.2,0.2 [mm]. Default: as planned."),
    ] = None
    modulus_ratio: Annotated[
        str | None,
        Parameter(help="Modulus of each layer over that of the film, bottom first, as 1,1,1,1. Default: 1 for each."),
    ] = None


@Parameter(name="*", group=POST)
@dataclass(frozen=True, kw_only=True)
class PostFlags:
    """What a pass of the post leaves behind."""

    line_width_mm: Annotated[
        float | None, Parameter(help="Width that one pass aligns, 0.2 or more [mm]. Default: as planned, 0.8.")
    ] = None
    edge_blur_mm: Annotated[float, Parameter(help="Blur at the edges of a scratched line [mm].")] = 0.1
    end_length_mm: Annotated[
        float, Parameter(help="Way that the post moves at the start of a pass before it aligns [mm].")
    ] = 0.0
    profile: Annotated[
        Literal["uniform", "skin"], Parameter(help="Alignment inside a scratched layer: even, or a skin of full order.")
    ] = "uniform"
    fading_tau_h: Annotated[
        float | None, Parameter(help="Time in which alignment fades before the cure [h], as 2.5. Default: it does not.")
    ] = None
    machine: Annotated[
        Path | None, Parameter(help="Machine (.toml) whose speeds tell how long alignment fades. Default: the paper's.")
    ] = None


@Parameter(name="*", group=SOLVER)
@dataclass(frozen=True, kw_only=True)
class SolverFlags:
    """How the shape is found."""

    mesh_mm: Annotated[float, Parameter(help="Edge length of the film's triangles, 0.05 to 5 [mm].")] = 0.6
    seeds: Annotated[
        int, Parameter(help="Heat this many times, each disturbed differently, and say whether the shapes agree.")
    ] = 1
    seed: Annotated[
        int,
        Parameter(
            help="Seed of all that is random: the flat film's disturbance, the scanner's noise, noisy films.",
            validator=Number(gte=0),
        ),
    ] = 0
    device: Annotated[
        Literal["auto", "cpu", "cuda"], Parameter(help="Where the kernels run; auto takes a GPU if present.")
    ] = "auto"


def film_options(material: MaterialFlags, post: PostFlags, solver: SolverFlags) -> FilmOptions:
    """Return how the film is made.

    Raises:
        InputError: if a list is not one of numbers, or the machine's file is wrong.
    """
    from planner.program import load_machine
    from scenes.sources import parse_numbers
    from twin.film import FilmOptions

    layers, ratio = material.layers_mm, material.modulus_ratio
    return FilmOptions(
        mesh_mm=solver.mesh_mm,
        edge_blur_mm=post.edge_blur_mm,
        line_width_mm=post.line_width_mm,
        end_length_mm=post.end_length_mm,
        profile=post.profile,
        fading_tau_h=post.fading_tau_h,
        machine=None if post.machine is None else load_machine(post.machine),
        layer_thickness_mm=None if layers is None else parse_numbers("--layers-mm", layers, "0.2,0.2,0.2,0.2"),
        modulus_ratio=None if ratio is None else parse_numbers("--modulus-ratio", ratio, "1,1,1,1"),
    )


def predict_options(
    heating: HeatingFlags, material: MaterialFlags, post: PostFlags, solver: SolverFlags
) -> PredictOptions:
    """Return the settings that the flags stand for.

    Raises:
        InputError: if a flag is out of range, cannot be read, or contradicts another.
    """
    from planner.errors import InputError
    from scenes.sources import open_temperature_field, parse_numbers
    from twin.cycle import cooled
    from twin.equilibrium import RampOptions
    from twin.predict import PredictOptions

    one, several = heating.temperature_c, heating.temperatures_c
    if one is not None and several is not None:
        raise InputError(
            f"--temperatures-c: found {several!r} together with --temperature-c {one:g}, allowed is one of the two; "
            "leave one out."
        )
    options = PredictOptions(
        film=film_options(material, post, solver),
        material=material.material(),
        ramp=RampOptions(tap_mm=heating.tap_mm),
        temperature_c=150.0 if one is None else one,
        temperatures_c=None if several is None else parse_numbers("--temperatures-c", several, "25,60,90,150,90,25"),
        temperature_field=open_temperature_field(heating.temperature_field),
        support=heating.support,
        device=solver.device,
        seed=solver.seed,
    )
    options = cooled(options) if heating.cool else options
    options.check()
    return options
