"""Predict a Program into a folder: result.json, shapes, pictures, report."""

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from planner.program import Program
from planner.target import Target
from scenes.output import output_folder, write_json
from scenes.pictures import draw_depth_images, draw_error_map, draw_hot_shape, draw_plan, draw_target
from scenes.report import write_report
from twin.bending import bending_radius_mm
from twin.cycle import Cycle, heat_and_cool
from twin.families import Family, shapes_by_seed
from twin.film import build_film, coarsen
from twin.predict import HotShape, PredictOptions, predict
from twin.scan import Scan, Scanner, pixel_centres
from twin.score import Scored, score_surface

COOLING_MESH_MM = 1.2
"""Cooling is followed step by step; this mesh shows whether a film comes back."""
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
    cool: bool = False,
    progress: Callable[[str, float], None] | None = None,
) -> Prediction:
    """Predict `program`, score it against `target` if there is one, and write everything into `folder`.

    Files: result.json, shape.ply (hot top face, in the target's frame where there is one), heating.npz (all accepted
    temperatures), scan.npz (depth images; can itself be scored again), pictures, report.html.

    Args:
        folder: where to write.
        program: what to predict.
        target: what to score against, or None.
        options: settings of the twin.
        scanner_noise: see the shape through the model of a phone's depth camera.
        seeds: heat this often, each time disturbed differently; the most frequent shape is the result, and each
            other one gets a picture.
        cool: cool again too, on a coarser mesh; writes cooling.npz.
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
        cycle = None
        if cool:
            coarse = coarsen(shape.film, max(options.film.mesh_mm, COOLING_MESH_MM))
            cycle = heat_and_cool(coarse, options, progress=progress)
            write_cycle(scratch / "cooling.npz", cycle)
        seen = Scan(vertices_mm=shape.top_mm, triangles=shape.film.triangles)
        if scanner_noise:
            seen = Scanner().scan(shape.top_mm, shape.film.triangles, np.random.default_rng(options.seed))
        report("scoring", 0.0)
        scored = None if target is None else score_surface(seen.vertices_mm, seen.triangles, target)
        report("scoring", 1.0)
        report("pictures", 0.0)
        triangles = shape.film.triangles
        surface = shape.top_mm if scored is None else scored.transform.apply(shape.top_mm)
        trimesh.Trimesh(surface, triangles, process=False).export(scratch / "shape.ply")
        np.savez_compressed(
            scratch / "heating.npz",
            temperature_c=shape.temperature_c,
            vertices_mm=shape.vertices_mm,
            triangles=triangles,
            flat_mm=shape.film.flat_mm,
        )
        caption = f"{options.temperature_c:g} C, {'on the hot plate' if options.support == 'plate' else 'weightless'}"
        if program.calibration.placeholder:
            caption += ", placeholder calibration"
        draw_hot_shape(scratch / "hot_shape.png", surface, triangles, caption=caption)
        for number, family in enumerate(families[1:], start=2):
            title = f"Another shape of the same film, {family.share:.0%} of {seeds} seeds"
            draw_hot_shape(scratch / f"hot_shape_{number}.png", family.shape.top_mm, triangles, title=title)
        draw_plan(scratch / "plan.png", program)
        if target is not None and scored is not None:
            draw_target(scratch / "target.png", target)
            write_score_files(scratch, target, scored)
        report("pictures", 1.0)
        wall_s = time.perf_counter() - started
        result = _result(program, target, options, shape, scored, scanner_noise=scanner_noise, wall_s=wall_s)
        result["warnings"] += _path_warnings(families, cycle)
        if seeds > 1:
            result["shapes_by_seed"] = [{"share": family.share, "seeds": family.seeds} for family in families]
        if cycle is not None:
            result["cooled_back_to_flat_mm"] = cycle.back_to_flat_mm
            result["snaps_between_c"] = cycle.snaps_between_c
        write_json(scratch / "result.json", result)
        write_report(scratch, result)
    return Prediction(shape=shape, scored=scored, result=result)


def write_cycle(path: Path, cycle: Cycle) -> None:
    """Write the shapes on the way up and on the way down, cold first."""
    np.savez_compressed(
        path,
        temperature_c=cycle.temperature_c,
        heated_mm=cycle.heated_mm,
        cooled_mm=cycle.cooled_mm,
        difference_mm=cycle.difference_mm,
    )


def _path_warnings(families: Sequence[Family], cycle: Cycle | None) -> list[str]:
    """Say what the user must know about the way the shape was reached."""
    warnings = []
    if len(families) > 1:
        shares = ", ".join(f"{family.share:.0%}" for family in families)
        warnings.append(
            f"The film has {len(families)} shapes, taken by {shares} of the seeds: which one a real film takes depends "
            "on chance. The most frequent is shown and scored."
        )
    if cycle is not None and cycle.snaps_between_c:
        ranges = ", ".join(f"{low:.0f} and {high:.0f} C" for low, high in cycle.snaps_between_c)
        warnings.append(f"Heating and cooling take different paths between {ranges}: the film snaps there.")
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


def _field_facts(options: PredictOptions) -> dict[str, Any]:
    """What is known of the temperature field, without its arrays."""
    facts: dict[str, Any] = {"kind": options.temperature_field.kind}
    plain = asdict(options.temperature_field)  # pyright: ignore[reportArgumentType]  # the fields are dataclasses
    return {**facts, **{key: value for key, value in plain.items() if isinstance(value, int | float | str)}}


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
    if shape.tapped_away_at_c:
        places = ", ".join(f"{value:.0f} C" for value in shape.tapped_away_at_c)
        warnings.append(
            f"At {places} the film was held down only by its weight: a tap of {options.ramp.tap_mm:g} mm let it jump "
            "to a shape of less energy, which is the one shown. A film that is never disturbed may stay flatter."
        )
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
        },
        "temperature_c": options.temperature_c,
        "temperature_field": options.temperature_field.kind,
        "support": options.support,
        "scanner_noise": scanner_noise,
        "settings": {**asdict(replace(options, device=shape.device)), "temperature_field": _field_facts(options)},
        "calibration": {"name": record.name, "placeholder": record.placeholder},
        "program_digest": program.digest,
        "target_digest": None if target is None else target.digest,
        "target_name": None if target is None else target.name,
        "warnings": warnings,
        "version": version("lce-twin"),
    }
