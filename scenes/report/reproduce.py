"""The commands that make the same prediction again, from what result.json and the Program say about it."""

import shlex
from collections.abc import Iterable
from dataclasses import fields
from pathlib import Path
from typing import Any

from planner.program import Inputs, Program
from scenes.given_flags import given
from scenes.noise_flags import DesignNoiseFlags, NoiseFlags
from scenes.predict_flags import (
    DesignHeatingFlags,
    DesignMaterialFlags,
    HeatingFlags,
    MaterialFlags,
    PostFlags,
    SolverFlags,
)

PLAN_AGAIN, PREDICT_AGAIN = "out/again", "out/again-hot"
PAPER_MACHINE = "paper"
HEATED = tuple(part.name for group in (DesignHeatingFlags, DesignMaterialFlags) for part in fields(group))
NOISE = tuple(part.name for part in fields(DesignNoiseFlags))


def plan_command(result: dict[str, Any], program: Program, source: str) -> str | None:
    """Return the command that plans the Program again from the target kept in its folder.

    None for what no plan gave: a film as run, a strip.

    Args:
        result: the content of result.json.
        program: the Program.
        source: its plan's folder, or its file.
    """
    inputs = program.inputs
    as_run = result["settings"]["film"]["pass_to_cure_s"] is not None
    if as_run or inputs.method not in ("perpendicular", "maximum", "inverse"):
        return None
    folder = Path(source).parent if Path(source).suffix else Path(source)
    flags = {"method": inputs.method, "seed": program.seed, **_method_flags(inputs)}
    if inputs.settings.get("machine", PAPER_MACHINE) != PAPER_MACHINE:
        flags["machine"] = "MACHINE.toml"
    if not program.calibration.placeholder:
        flags["calibration"] = "CALIBRATION.toml"
    layers = {"layers_mm": _listed(program.film.layer_thickness_mm)}
    written = " ".join(_written({**flags, **layers}))
    return f"lce plan {shlex.quote(str(folder / 'target.npz'))} {written} --out {PLAN_AGAIN}"


def predict_command(result: dict[str, Any], program: Program, source: str) -> str:
    """Return the command that predicts the Program again.

    Args:
        result: the content of result.json.
        program: the Program.
        source: what was predicted: a plan's folder, a Program's file, or a run's.
    """
    groups = _heating(result), _material(result), _post(result), _solver(result), _noise(result)
    flags = [flag for group in groups for flag in given(group)]
    if result["scanner_noise"]:
        flags.append("--scanner-noise")
    if result["target_digest"] not in (None, program.inputs.target_sha256):
        flags.append("--target TARGET")
    draws = result.get("score_band", {}).get("draws")
    if draws is not None:
        flags.append(f"--calibration-draws {draws}")
    return " ".join(["lce predict", shlex.quote(source), *flags, f"--out {PREDICT_AGAIN}"])


def _method_flags(inputs: Inputs) -> dict[str, Any]:
    """Return the settings that the planner kept, by their flags."""
    names = {
        "perpendicular": ("flattening", "tracer", "margin_mm"),
        "maximum": ("flattening", "tracer", "margin_mm"),
        "inverse": ("stack", "robust", *NOISE, *HEATED),
    }
    return {name: inputs.settings[name] for name in names[inputs.method] if name in inputs.settings}


def _heating(result: dict[str, Any]) -> HeatingFlags:
    settings = result["settings"]
    one, several, kind = settings["temperature_c"], settings["temperatures_c"], result["temperature_field"]
    return HeatingFlags(
        temperature_c=one if several is None and one != 150.0 else None,
        temperatures_c=None if several is None else _listed(several),
        temperature_field=kind if kind in ("uniform", "gap_model") else "FIELD.npz",
        tap_mm=settings["ramp"]["tap_mm"],
        support=settings["support"],
    )


def _material(result: dict[str, Any]) -> MaterialFlags:
    film = result["settings"]["film"]
    layers, ratio = film["layer_thickness_mm"], film["modulus_ratio"]
    return MaterialFlags(
        **result["settings"]["material"],
        layers_mm=None if layers is None else _listed(layers),
        modulus_ratio=None if ratio is None else _listed(ratio),
    )


def _post(result: dict[str, Any]) -> PostFlags:
    film = result["settings"]["film"]
    return PostFlags(
        line_width_mm=film["line_width_mm"],
        edge_blur_mm=film["edge_blur_mm"],
        end_length_mm=film["end_length_mm"],
        profile=film["profile"],
        fading_tau_h=film["fading_tau_h"],
        machine=None if film["machine"] is None else Path("MACHINE.toml"),
    )


def _solver(result: dict[str, Any]) -> SolverFlags:
    settings = result["settings"]
    seeds = sum(len(family["seeds"]) for family in result.get("shapes_by_seed", ())) or 1
    return SolverFlags(
        mesh_mm=settings["film"]["mesh_mm"], seeds=seeds, seed=settings["seed"], device=settings["device"]
    )


def _noise(result: dict[str, Any]) -> NoiseFlags:
    if "noise" not in result:
        return NoiseFlags()
    noise = result["noise"]
    strays = {f"noise_{name}": value for name, value in noise["standard_deviations"].items()}
    return NoiseFlags(noise=noise["count"], noise_mesh_mm=noise["mesh_mm"], **strays)


def _written(flags: dict[str, Any]) -> Iterable[str]:
    for name, value in flags.items():
        flag = f"--{name.replace('_', '-')}"
        if value is True:
            yield flag
        elif value is not False:
            yield f"{flag} {shlex.quote(str(value))}"


def _listed(values: Iterable[float]) -> str:
    return ",".join(str(value).removesuffix(".0") for value in values)
