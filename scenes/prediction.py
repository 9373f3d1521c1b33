"""Predict a Program into a folder: result.json, shapes, pictures, report."""

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from math import degrees
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from planner.program import (
    Cure,
    Machine,
    Program,
    ResetAlignment,
    check,
    layer_figures,
    layer_times,
    load_machine,
)
from planner.target import Target
from scenes.calibration_band import band_summary, score_drawn_calibrations
from scenes.output import output_folder, write_json
from scenes.pictures import (
    draw_depth_images,
    draw_error_map,
    draw_hot_shape,
    draw_noise,
    draw_plan,
    draw_side_by_side,
    draw_target,
)
from scenes.report import ReportContents, write_report
from scenes.robustness import MESH_MM, Robustness, robustness_summary, score_noisy_films
from twin.batch import ProcessNoise
from twin.bending import bending_radius_mm
from twin.cycle import back_to_flat_mm, depth_mm, hysteresis_mm, level_mm
from twin.families import Family, shapes_by_seed
from twin.film import build_film
from twin.predict import HotShape, PredictOptions, predict
from twin.scan import Scan, Scanner, pixel_centres
from twin.score import Scored, score_surface

APART_MM = 0.05
"""Shapes at one temperature that differ by more are told."""
PAPER_SSIM = 0.845
"""What the paper's best face reached by Eq. 4 (section 2.4)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Prediction:
    """A predicted shape and, where there was a target, its score."""

    shape: HotShape
    scored: Scored | None
    result: dict[str, Any]
    """The content of result.json."""


def predict_into(
    folder: Path,
    program: Program,
    target: Target | None,
    options: PredictOptions,
    *,
    scanner_noise: bool = False,
    seeds: int = 1,
    noisy_films: int = 0,
    noise: ProcessNoise | None = None,
    noise_mesh_mm: float = MESH_MM,
    calibration_draws: int = 0,
    plan_figures: dict[str, Any] | None = None,
    source: str | Path = "PLAN",
    progress: Callable[[str, float], None] | None = None,
) -> Prediction:
    """Predict `program`, score it against `target` if there is one, and write everything into `folder`.

    Files: result.json, shape.ply (hot top face, in the target's frame where there is one), heating.npz (all accepted
    temperatures, and which of them were asked for), scan.npz (depth images; can itself be scored again), pictures,
    report.html.

    Args:
        folder: where to write.
        program: what to predict.
        target: what to score against, or None.
        options: settings of the twin.
        scanner_noise: see the shape through the model of a phone's depth camera.
        seeds: heat this often, each time disturbed differently; the most frequent shape is the result, and all are
            shown side by side.
        noisy_films: score so many films with errors of the process, too; needs a target.
        noise: these errors; None: the defaults.
        noise_mesh_mm: edge of those films' triangles, unless that of the options is longer.
        calibration_draws: score so many films of maps that the calibration's strips leave possible, too, where there
            is a target and the calibration says how uncertain it is.
        plan_figures: the content of the plan's plan.json, which knows what was clamped and noted; None: unknown.
        source: what is predicted, as the user named it, for the report's commands.
        progress: called with the stage's name and the share done, 0 to 1.

    Raises:
        InputError: for wrong options, or if the folder cannot be written.
        SolverError: if no equilibrium is found.
    """
    started = time.perf_counter()
    report = progress or (lambda stage, share: None)
    with output_folder(folder) as scratch:
        if seeds > 1:
            families = shapes_by_seed(build_film(program, options.film), options, seeds, progress=progress)
            shape = families[0].shape
        else:
            shape = predict(program, options, progress=progress)
            families = (Family(shape=shape, seeds=(options.seed,), share=1.0),)
        seen = Scan(vertices_mm=shape.top_mm, triangles=shape.film.triangles)
        if scanner_noise:
            seen = Scanner().scan(shape.top_mm, shape.film.triangles, np.random.default_rng(options.seed))
        report("scoring", 0.0)
        scored = None if target is None else score_surface(seen.vertices_mm, seen.triangles, target)
        report("scoring", 1.0)
        robustness = None
        if target is not None and noisy_films:
            robustness = score_noisy_films(
                program,
                target,
                options,
                noise or ProcessNoise(),
                noisy_films,
                mesh_mm=noise_mesh_mm,
                progress=progress,
            )
        band = None
        if target is not None and calibration_draws and program.calibration.uncertainty is not None:
            band = score_drawn_calibrations(program, target, options, calibration_draws, progress=progress)
        report("pictures", 0.0)
        triangles = shape.film.triangles
        surface = shape.top_mm if scored is None else scored.transform.apply(shape.top_mm)
        trimesh.Trimesh(surface, triangles, process=False).export(scratch / "shape.ply")
        np.savez_compressed(
            scratch / "heating.npz",
            temperature_c=shape.temperature_c,
            vertices_mm=shape.vertices_mm,
            stops=[stop.index for stop in shape.stops],
            triangles=triangles,
            flat_mm=shape.film.flat_mm,
        )
        caption = f"{options.hottest_c:g} C, {'on the hot plate' if options.support == 'plate' else 'weightless'}"
        if program.calibration.placeholder:
            caption += ", placeholder calibration"
        draw_hot_shape(scratch / "hot_shape.png", surface, triangles, caption=caption)
        if len(families) > 1:
            draw_side_by_side(
                scratch / "shapes_by_seed.png",
                [level_mm(family.shape, family.shape.hottest) for family in families],
                triangles,
                [f"{family.share:.0%} of {seeds} seeds" for family in families],
                title="Shapes that differently disturbed films take",
            )
        if len(shape.stops) > 1:
            draw_side_by_side(
                scratch / "temperatures.png",
                [level_mm(shape, stop.index) for stop in shape.stops],
                triangles,
                [f"{stop.temperature_c:g} C" for stop in shape.stops],
                title="The film at each temperature, one after the other",
            )
        draw_plan(scratch / "plan.png", program)
        if robustness is not None:
            _draw_robustness(scratch, robustness)
        if target is not None and scored is not None:
            draw_target(scratch / "target.png", target)
            write_score_files(scratch, target, scored)
        report("pictures", 1.0)
        wall_s = time.perf_counter() - started
        machine = options.film.machine or load_machine()
        result = {
            **_result(program, target, options, shape, scored, scanner_noise=scanner_noise, wall_s=wall_s),
            **_making(program, machine),
            "clamped": _clamped(plan_figures),
            "plan_notes": [] if plan_figures is None else _plan_notes(plan_figures),
        }
        if seeds > 1:
            result["warnings"] += _family_warnings(families)
            result["shapes_by_seed"] = [
                {"share": family.share, "seeds": family.seeds, "depth_mm": depth_mm(family.shape, family.shape.hottest)}
                for family in families
            ]
        if robustness is not None:
            result["noise"] = robustness_summary(robustness)
        if band is not None:
            result["score_band"] = band_summary(band, program.calibration.name)
        write_json(scratch / "result.json", result)
        contents = ReportContents(
            result=result,
            program=program,
            machine=machine,
            shape=shape,
            target=target,
            scored=scored,
            source=str(source),
        )
        write_report(scratch, contents)
    return Prediction(shape=shape, scored=scored, result=result)


def _making(program: Program, machine: Machine) -> dict[str, Any]:
    """Return what the machine has to do for this film, how long it takes, and what stands against it."""
    waits = [
        op.duration_s for layer in program.layers for op in layer.operations if isinstance(op, ResetAlignment | Cure)
    ]
    return {
        "machine": {
            "name": machine.name,
            "budget_s": machine.layer.budget_s,
            "reset_and_cure_s": sum(waits),
            "problems": [asdict(problem) for problem in check(program, machine)],
        },
        "layers": layer_figures(program, layer_times(program, machine)),
    }


def _clamped(plan_figures: dict[str, Any] | None) -> dict[str, float] | None:
    """Return the shares of the target's points that bend tighter and wider than the calibration reaches, if known."""
    if plan_figures is None or "clamped_tight_share" not in plan_figures:
        return None
    return {"tight_share": plan_figures["clamped_tight_share"], "wide_share": plan_figures["clamped_wide_share"]}


def _plan_notes(plan_figures: dict[str, Any]) -> list[str]:
    """Return what the planner noted, and what it says to limit a design."""
    return [*plan_figures.get("notes", ()), *plan_figures.get("limits", ())]


def _family_warnings(families: Sequence[Family]) -> list[str]:
    """Say which shape is shown if the film has several."""
    if len(families) == 1:
        return []
    shares = ", ".join(f"{family.share:.0%}" for family in families)
    return [
        f"The film has {len(families)} shapes, taken by {shares} of the seeds: which one a real film takes depends on "
        "chance. The most frequent is shown and scored."
    ]


def _path_warnings(shape: HotShape, options: PredictOptions) -> list[str]:
    """Say what the user must know about the way the shape was reached."""
    warnings = []
    if shape.tapped_away_at_c:
        places = ", ".join(f"{value:.0f} C" for value in shape.tapped_away_at_c)
        warnings.append(
            f"At {places} the film was held down only by its weight: a tap of {options.ramp.tap_mm:g} mm let it jump "
            "to a shape of less energy, which is the one shown. A film that is never disturbed may stay flatter."
        )
    for way, cooling in (("heated", False), ("cooled", True)):
        snaps = [snap for snap in shape.snaps if snap.cooling == cooling]
        if snaps:
            places = ", ".join(f"at {snap.temperature_c:.0f} C by {snap.distance_mm:.1f} mm" for snap in snaps)
            warnings.append(f"The film snapped {places} while it was {way}: a real one moves suddenly there.")
    for temperature, apart in hysteresis_mm(shape).items():
        if apart > APART_MM:
            warnings.append(
                f"At {temperature:g} C the film has shapes up to {apart:.1f} mm apart: which one depends on where it "
                "comes from."
            )
    return warnings


def write_score_files(folder: Path, target: Target, scored: Scored) -> None:
    """Write what belongs to a score: the depth images as scan.npz and as a picture, and the error map."""
    centres = pixel_centres(target.bounds_mm)
    # rows of an image run from the top, a height map's from the bottom: flipped, the file can be scored as a scan
    np.savez_compressed(
        folder / "scan.npz",
        x_mm=centres[0, :, 0],
        y_mm=centres[::-1, 0, 1],
        z_mm=scored.shape_depth_mm[::-1],
        target_z_mm=scored.target_depth_mm[::-1],
        ssim_map=scored.ssim_map[::-1],
    )
    draw_depth_images(
        folder / "depth_images.png",
        target,
        scored.target_depth_mm,
        scored.shape_depth_mm,
        scored.ssim_map,
        scored.score,
    )
    draw_error_map(
        folder / "error_map.png",
        scored.vertices_mm,
        scored.triangles,
        scored.error_mm,
        rms_mm=scored.score.rms_mm,
        hausdorff_mm=scored.score.hausdorff_mm,
    )


def _draw_robustness(folder: Path, robustness: Robustness) -> None:
    noise = robustness.noise
    draw_noise(
        folder / "noise.png",
        robustness.scores,
        robustness.planned,
        robustness.contraction,
        robustness.costs,
        caption=f"standard deviations: strain {noise.strain:.0%}, of each layer {noise.layer_strain:.0%}, direction "
        f"{degrees(noise.direction_rad):g} deg over {noise.direction_length_mm:g} mm, registration "
        f"{noise.registration_mm:g} mm; mesh of {robustness.mesh_mm:g} mm",
    )


def plain_settings(options: PredictOptions) -> dict[str, Any]:
    """Return all settings without the arrays of a temperature field, the machine by its name."""
    settings, machine = asdict(options), options.film.machine
    field = asdict(options.temperature_field)  # pyright: ignore[reportArgumentType]  # the fields are dataclasses
    facts = {key: value for key, value in field.items() if isinstance(value, int | float | str)}
    return {
        **settings,
        "film": {
            **settings["film"],
            "machine": None if machine is None else machine.name,
            "pass_to_cure_s": None if options.film.pass_to_cure_s is None else "as run",
            "pass_strength": None if options.film.pass_strength is None else "as run",
        },
        "temperature_field": {"kind": options.temperature_field.kind, **facts},
    }


def _result(
    program: Program,
    target: Target | None,
    options: PredictOptions,
    shape: HotShape,
    scored: Scored | None,
    *,
    scanner_noise: bool,
    wall_s: float,
) -> dict[str, Any]:
    record = program.calibration
    warnings = []
    if record.placeholder:
        warnings.append(
            f"Calibration '{record.name}' is a placeholder: loads and speeds are not measured, so this predicts what "
            "an ideal machine with the published range would make."
        )
    warnings += _path_warnings(shape, options)
    if not shape.stable:
        warnings.append("The equilibrium is not stable: another shape with less energy lies nearby.")
    strip = {}
    if program.inputs.method == "strip":
        promised = program.inputs.settings["radius_mm"]
        strip = {"bending_radius_mm": bending_radius_mm(shape), "promised_radius_mm": promised}
    return {
        **strip,
        **({} if scored is None else asdict(scored.score)),
        "paper_ssim": PAPER_SSIM,
        "name": program.name,
        "method": program.inputs.method,
        "triangle_count": len(shape.film.triangles),
        "newton_iterations": shape.newton_iterations,
        "accepted_temperatures_c": shape.temperature_c,
        "wall_s": wall_s,
        "heating_wall_s": shape.wall_s,
        "device": shape.device,
        "seed": options.seed,
        "equilibrium": {
            "relative_residual": shape.relative_residual,
            "energy_mj": shape.energy_mj,
            "stable": shape.stable,
            "lowest_stiffness_n_mm3": shape.lowest_stiffness_n_mm3,
            "tapped_away_at_c": shape.tapped_away_at_c,
            "snaps": [asdict(snap) for snap in shape.snaps],
        },
        "temperature_c": options.hottest_c,
        "stops": [{**asdict(stop), "depth_mm": depth_mm(shape, stop.index)} for stop in shape.stops],
        "cooled_back_to_flat_mm": back_to_flat_mm(shape),
        "largest_contraction": float(shape.film.contraction.max()),
        "temperature_field": options.temperature_field.kind,
        "support": options.support,
        "scanner_noise": scanner_noise,
        "settings": plain_settings(replace(options, device=shape.device)),
        "calibration": {"name": record.name, "placeholder": record.placeholder},
        "calibration_provenance": dict(record.provenance),
        "program_digest": program.digest,
        "target_digest": None if target is None else target.digest,
        "target_name": None if target is None else target.name,
        "warnings": warnings,
        "version": version("lce-twin"),
    }
