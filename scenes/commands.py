"""What the subcommands of `lce` do: compose the rooms, and tell the user what came out."""

import sys
from collections.abc import Sequence
from dataclasses import asdict, replace
from datetime import datetime
from pathlib import Path
from typing import Any, Literal

from planner.calibration import Calibration, load_calibration
from planner.errors import InputError
from planner.plan import Plan, plan_summary
from planner.program import Machine, Program, load_machine, load_program
from planner.target import Target
from scenes.calibrating import NOT_STATED, calibrate_into
from scenes.case import PlanSettings, list_cases, load_case
from scenes.case_target import Strip
from scenes.checkpoint import inputs_digest, load_checkpoint
from scenes.costs_in_words import costs_in_words
from scenes.exports import export_into
from scenes.filming import film_into
from scenes.given_flags import given
from scenes.inverse_flags import InverseFlags, inverse_options
from scenes.inverse_planning import plan_inverse_into
from scenes.new_scene import write_new_scene
from scenes.noise_flags import DesignNoiseFlags, NoiseFlags
from scenes.output import output_folder, write_json
from scenes.plan_folder import plans_figures, plans_target
from scenes.planning import plan_into, plan_strip_into
from scenes.predict_flags import (
    DesignHeatingFlags,
    DesignMaterialFlags,
    HeatingFlags,
    MaterialFlags,
    PostFlags,
    SolverFlags,
    predict_options,
)
from scenes.prediction import PAPER_SSIM, Prediction, predict_into, write_score_files
from scenes.progress import progress_bar
from scenes.search_folder import CHECKPOINT_FILE, CURRENT_FILE, search_folder
from scenes.sources import as_it_was_run, open_as_run, open_source, parse_layers
from twin.film import FilmOptions
from twin.inverse import FINER, STRONGER, InverseDesign, InverseOptions
from twin.predict import PredictOptions
from twin.scan import read_scan
from twin.score import Score, score_surface


def say(text: str) -> None:
    """Write a line for the user to stdout."""
    sys.stdout.write(text + "\n")


def list_scenes() -> None:
    """Print the built-in cases, one a line."""
    for case in list_cases():
        say(f"{case.name:<16} {case.description}")


def run_new(scene: str, like: str | None) -> None:
    """Write a scene file to start from."""
    path = write_new_scene(scene, like)
    say(f"scene written to {path}; change it, then: lce plan {path} --out out/{path.stem}")


def run_plan(
    target: str,
    out: Path,
    *,
    method: Literal["perpendicular", "maximum", "inverse"] | None,
    tracer: Literal["greedy", "dense"] | None,
    size_mm: str | None,
    up: str,
    depth_mm: float | None,
    flattening: Literal["arap", "grid"] | None,
    calibration: Path | None,
    machine: Path | None,
    layers_mm: str,
    margin_mm: float | None,
    seed: int | None,
    inverse: InverseFlags,
    heating: DesignHeatingFlags,
    material: DesignMaterialFlags,
    noise: DesignNoiseFlags,
) -> None:
    """Plan a target into a folder; what the user leaves open comes from the case, or is the default."""
    surface, case = open_source(target, size_mm=size_mm, up=up, depth_mm=depth_mm)
    asked = {"tracer": tracer, "flattening": flattening, "margin_mm": margin_mm}
    asked = {name: value for name, value in asked.items() if value is not None}
    searched = [flag for group in (inverse, heating, material, noise) for flag in given(group)]
    shared = {"calibration": load_calibration(calibration), "machine": load_machine(machine)}
    if case and isinstance(case.target, Strip):
        _refuse(
            [*(("--method inverse",) if method == "inverse" else ()), *searched],
            f"is for surfaces, but {case.name} is a calibration strip, whose passes follow from its radius",
        )
        _plan_strip(out, case.name, case.target, **shared)
        return
    settings = (case.plan if case else PlanSettings()).model_copy(
        update=asked if seed is None else {**asked, "seed": seed}
    )
    method = method or settings.method
    thickness = parse_layers(layers_mm)
    if method == "inverse":
        _refuse(
            [f"--{name.replace('_', '-')} {value}" for name, value in asked.items()],
            "is for the methods perpendicular and maximum, but the method is inverse, which needs none of it",
        )
        options = inverse_options(inverse, heating, material, noise, layer_thickness_mm=thickness, seed=settings.seed)
        _plan_inverse(out, surface, options, resume=inverse.resume, **shared)
        return
    _refuse(searched, f"is for --method inverse, but the method is {method}")
    with progress_bar() as bars:
        made = plan_into(
            out,
            surface,
            layer_thickness_mm=thickness,
            progress=bars,
            **shared,
            **{**settings.model_dump(), "method": method},
        )
    _tell_plan(made)
    say(f"plan written to {out}")


def _plan_strip(out: Path, name: str, strip: Strip, *, calibration: Calibration, machine: Machine) -> None:
    program = plan_strip_into(
        out,
        calibration,
        name=name,
        length_mm=strip.length_mm,
        width_mm=strip.width_mm,
        radius_mm=strip.bending_radius_mm,
        machine=machine,
    )
    _tell_calibration(program)
    say(f"plan written to {out}")


def _plan_inverse(
    out: Path, target: Target, options: InverseOptions, *, resume: bool, calibration: Calibration, machine: Machine
) -> None:
    searching = search_folder(out)
    inputs = inputs_digest(target, calibration, options)
    kept = load_checkpoint(searching / CHECKPOINT_FILE, inputs) if resume else None
    say(f"{searching / CURRENT_FILE} shows the present shape")
    try:
        with progress_bar() as bars:
            made = plan_inverse_into(
                out,
                target,
                calibration=calibration,
                machine=machine,
                options=options,
                resume=kept,
                progress=bars,
                watch=lambda moment: bars.note(moment.stage, f"SSIM {moment.ssim:.3f}, RMS {moment.rms_mm:.2f} mm"),
            )
    except KeyboardInterrupt:
        if (searching / CHECKPOINT_FILE).exists():
            say(f"the search so far is in {searching}: repeat the command with --resume to go on from there")
        raise
    _tell_design(made)
    say(f"plan written to {out}")


def _refuse(flags: Sequence[str], reason: str) -> None:
    """Refuse flags that do not apply."""
    if flags:
        raise InputError(f"{', '.join(flags)}: {reason}; leave {'it' if len(flags) == 1 else 'them'} out.")


def run_predict(
    program: Path,
    out: Path,
    *,
    target: str | None,
    scanner_noise: bool,
    calibration_draws: int = 0,
    heating: HeatingFlags,
    material: MaterialFlags,
    post: PostFlags,
    solver: SolverFlags,
    noise: NoiseFlags,
) -> None:
    """Predict a Program into a folder and score it against its plan's target, or another."""
    if solver.seeds < 1:
        raise InputError(f"--seeds: found {solver.seeds}, allowed is 1 or more; 1 heats the film once.")
    options = predict_options(heating, material, post, solver)
    made_film = open_as_run(program)
    if made_film is None:
        loaded = load_program(program)
    else:
        loaded = made_film.program
        options = replace(options, film=as_it_was_run(options.film, made_film))
        for note in made_film.notes:
            say(f"note: {note}")
    process_noise = noise.process_noise()
    surface = open_source(target)[0] if target else plans_target(program, loaded.inputs.target_sha256)
    if noise.noise and surface is None:
        raise InputError(
            f"--noise: found {noise.noise} films, but {program} has no target to score them against; name one with "
            "--target."
        )
    with progress_bar() as progress:
        made = predict_into(
            out,
            loaded,
            surface,
            options,
            scanner_noise=scanner_noise,
            seeds=solver.seeds,
            noisy_films=noise.noise,
            noise=process_noise,
            noise_mesh_mm=noise.noise_mesh_mm,
            calibration_draws=calibration_draws,
            plan_figures=plans_figures(program, loaded.digest),
            source=program,
            progress=progress,
        )
    _tell_prediction(made)
    say(f"results written to {out}, start with {out / 'report.html'}")


def run_score(scan: Path, out: Path, *, target: str, size_mm: str | None, up: str, depth_mm: float | None) -> None:
    """Score a scan file against a target into a folder."""
    surface = open_source(target, size_mm=size_mm, up=up, depth_mm=depth_mm)[0]
    seen = read_scan(scan)
    with output_folder(out) as scratch:
        scored = score_surface(seen.vertices_mm, seen.triangles, surface, coarse=True)
        write_score_files(scratch, surface, scored)
        result = {
            **asdict(scored.score),
            "scan": scan.name,
            "target_name": surface.name,
            "target_digest": surface.digest,
            "registration_residual_mm": scored.transform.residual_mm,
            "notes": [*surface.notes, *seen.notes],
        }
        write_json(scratch / "result.json", result)
    _tell_score(scored.score)
    say(f"score written to {out}")


def run_calibrate(
    strips: Path,
    out: Path,
    *,
    name: str | None,
    operator: str | None,
    date: str | None,
    method: str | None,
    layers_mm: str,
) -> None:
    """Fit a calibration to a file of strips, and tell what was found."""
    provenance = {
        "date": date or f"{datetime.now().astimezone():%Y-%m-%d}, when it was fitted",
        "operator": operator or NOT_STATED,
        "method": method or NOT_STATED,
    }
    fit = calibrate_into(out, strips, name=name, provenance=provenance, layer_thickness_mm=parse_layers(layers_mm))
    record = fit.calibration.record
    for note in fit.notes:
        say(f"note: {note}")
    for outlier in fit.outliers:
        say(f"outlier: {outlier.sentence}")
    for key in ("samples", "scatter", "left_out_error", "band", "strip_width", "width_correction"):
        say(f"{key.replace('_', ' ')}: {record.provenance[key]}")
    limits = record.limits
    say(
        f"calibration '{record.name}': {limits.radius_mm_min:.3g} to {limits.radius_mm_max:.3g} mm at "
        f"{limits.load_g_min:g} to {limits.load_g_max:g} g and {limits.speed_mm_s_min:g} to {limits.speed_mm_s_max:g} "
        f"mm/s; written to {out} with its picture {out.with_suffix('.png')}"
    )


def run_export(source: Path, out: Path) -> None:
    """Export a plan or a prediction."""
    names = export_into(out, source)
    say(f"{len(names)} files written to {out}: {', '.join(names)}")


def run_film(prediction: Path, out: Path, *, frames: int | None) -> None:
    """Film the heating of a prediction."""
    with progress_bar() as progress:
        count = film_into(out, prediction, frames=frames, progress=progress)
    say(f"{count} pictures written to {out}")


def run_demo(out: Path) -> None:
    """Plan and predict the built-in face."""
    case = load_case("face")
    target = case.make_target()
    with progress_bar() as progress:
        made = plan_into(out, target, progress=progress, **case.plan.model_dump())
        options = PredictOptions(
            film=FilmOptions(mesh_mm=case.predict.mesh_mm),
            temperature_c=case.predict.temperature_c,
            support=case.predict.support,
            seed=case.predict.seed,
        )
        predicted = predict_into(
            out, made.program, target, options, plan_figures=plan_summary(made), source=out, progress=progress
        )
    _tell_plan(made)
    _tell_prediction(predicted)
    say(f"pictures, {out / 'result.json'} and the rest are in {out}, start with {out / 'report.html'}")


def _tell_calibration(program: Program) -> None:
    record = program.calibration
    if record.placeholder:
        say(f"note: calibration '{record.name}' is a placeholder: its radii are not measured.")
    else:
        say(f"calibration '{record.name}', measured: {record.provenance.get('samples', 'nothing more is stated')}")


def _tell_plan(made: Plan) -> None:
    if not made.program.calibration.placeholder:
        _tell_calibration(made.program)
    _tell_layers(made)
    say(
        f"clamped: {made.clamped_tight_share:.0%} of the points bend tighter than the calibration reaches, "
        f"{made.clamped_wide_share:.0%} wider (the paper's face: 3 % and 41 %)"
    )


def _tell_design(made: InverseDesign) -> None:
    _tell_calibration(made.program)
    _tell_layers(made)
    _tell_score(made.score)
    say("what limits it, each switched off:")
    say(
        f"  passes: smooth fields without passes reach SSIM (Eq. 4) {made.ideal.ssim_eq4:.3f}, "
        f"rms_mm {made.ideal.rms_mm:.3f}"
    )
    if made.finer is not None:
        say(f"  mesh: with edges of {FINER:g} times the length {made.finer.ssim_eq4:.3f}, {made.finer.rms_mm:.3f} mm")
    if made.wider_range_share is not None:
        say(
            f"  contractions: were they {STRONGER:g} times as large, the best flat film would keep "
            f"{made.wider_range_share:.0%} of its elastic energy at the target"
        )
    if made.noise_costs is not None:
        say(f"  errors of the process: {costs_in_words(made.noise_costs)}")
    say("  lce predict --noise 32 shows how films with errors of the process score")
    for limit in made.limits:
        say(f"limit: {limit}")


def _tell_layers(made: Plan | InverseDesign) -> None:
    for note in made.notes:
        say(f"note: {note}")
    for problem in made.problems:
        say(f"{problem.severity}: {problem.where}: {problem.message}")
    for layer, time in zip(made.program.layers, made.layer_times, strict=True):
        if layer.passes:
            length = sum(stroke.length_mm for stroke in layer.passes)
            say(f"layer {layer.index + 1}: {len(layer.passes)} passes, {length:.0f} mm, {time.total_s / 60:.0f} min")


def _tell_prediction(made: Prediction) -> None:
    for warning in made.result["warnings"]:
        say(f"warning: {warning}")
    for stop in made.result["stops"] if len(made.shape.stops) > 1 else ():
        state = "stable" if stop["stable"] else "not stable"
        say(f"{stop['temperature_c']:g} C: {stop['depth_mm']:.1f} mm deep, {state}")
    if made.scored is None:
        say("no target: the shape was not scored")
        if "bending_radius_mm" in made.result:
            found, promised = made.result["bending_radius_mm"], made.result["promised_radius_mm"]
            say(f"bending radius {found:.3g} mm in the middle, the calibration promises {promised:.3g} mm")
    else:
        _tell_score(made.scored.score)
    if "score_band" in made.result:
        band = made.result["score_band"]
        ssim, rms = band["ssim_eq4"], band["rms_mm"]
        low, _, high = band["percent"]
        say(
            f"as well as calibration '{band['calibration']}' is known: SSIM (Eq. 4) {ssim['low']:.3f} to "
            f"{ssim['high']:.3f}, rms_mm {rms['low']:.3f} to {rms['high']:.3f} ({low} to {high} % of {band['draws']} "
            f"films on a mesh of {band['mesh_mm']:g} mm; {ssim['expected']:.3f} and {rms['expected']:.3f} as expected)"
        )
    if "noise" in made.result:
        noise = made.result["noise"]
        low, middle, high = noise["percentiles"]["ssim_eq4"].values()
        say(
            f"{noise['count']} noisy films on a mesh of {noise['mesh_mm']:g} mm: SSIM (Eq. 4) {low:.3f}, {middle:.3f}, "
            f"{high:.3f} at 10, 50, 90 %; {noise['without_noise']['ssim_eq4']:.3f} without noise"
        )
        if noise["expected_cost"] is not None:
            say(f"errors of the process: {costs_in_words(noise['expected_cost'])}")


def _tell_score(score: Score) -> None:
    numbers: dict[str, Any] = asdict(score)
    say(f"SSIM (Eq. 4) {score.ssim_eq4:.3f}; the paper's best face: {PAPER_SSIM:.3f}")
    say(", ".join(f"{name} {value:.3f}" for name, value in numbers.items() if name != "ssim_eq4"))
