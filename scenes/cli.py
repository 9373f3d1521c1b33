"""The `lce` command: each subcommand is one call into `scenes.commands`.

Heavy libraries are imported inside the commands, so that `lce --help` answers at once.
"""

import sys
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Literal, NoReturn

from cyclopts import App, CycloptsError, Parameter
from cyclopts.validators import Number

from planner.errors import InputError, LceError
from scenes.inverse_flags import InverseFlags
from scenes.noise_flags import DesignNoiseFlags, NoiseFlags
from scenes.predict_flags import (
    DesignHeatingFlags,
    DesignMaterialFlags,
    HeatingFlags,
    MaterialFlags,
    PostFlags,
    SolverFlags,
)

app = App(
    name="lce",
    help="Plan, predict and score morphing liquid crystal elastomer films before they are printed.",
    version=lambda: version("lce-twin"),
    suppress_keyboard_interrupt=False,
)

app.register_install_completion_command(
    help="Install completion of commands and flags for this shell (bash, zsh, fish), and leave."
)

Out = Annotated[Path, Parameter(help="Folder for the results; made if absent. Files appear whole or not at all.")]
TargetText = Annotated[
    str,
    Parameter(
        help="Built-in scene (see `lce scenes`), scene file (.toml), mesh (.stl .obj .ply .glb .off), point cloud "
        "(.ply .xyz) or height map (.npz; .png .tif with --depth-mm)."
    ),
]
SizeMm = Annotated[
    str | None,
    Parameter(help="Scale the target, evenly in x, y and z, to fit into this box, as 40x60 [mm]. Default: as it is."),
]
Up = Annotated[
    Literal["+x", "-x", "+y", "-y", "+z", "-z"], Parameter(help="Axis of the file that points up, out of the plate.")
]
DepthMm = Annotated[
    float | None,
    Parameter(
        help="Height between the darkest and the brightest grey of an image, up to 300 [mm].",
        validator=Number(gt=0, lte=300),
    ),
]


@app.command
def demo(*, out: Out = Path("out/demo")) -> None:
    """Plan and predict the built-in face, end to end, with pictures and a report."""
    from scenes.commands import run_demo

    run_demo(out)


@app.command
def scenes() -> None:
    """List the built-in cases."""
    from scenes.commands import list_scenes

    list_scenes()


@app.command
def new(
    scene: Annotated[str, Parameter(help="Name of the new scene, or file to write (.toml).")],
    *,
    like: Annotated[
        str | None,
        Parameter(help="Built-in scene to start from. Default: the one of this name, else oblate_dome."),
    ] = None,
) -> None:
    """Write a commented scene file that `lce plan` runs as it is."""
    from scenes.commands import run_new

    run_new(scene, like)


@app.command
def plan(
    target: TargetText,
    *,
    out: Out,
    method: Annotated[
        Literal["perpendicular", "maximum", "inverse"] | None,
        Parameter(
            help="Scratch across the local incline, or along the largest curvature (paper, section 2.2); or inverse: "
            "search all layers for what the heated film needs to become the target, in minutes. "
            "Default: the case's, else perpendicular."
        ),
    ] = None,
    tracer: Annotated[
        Literal["greedy", "dense"] | None,
        Parameter(
            help="Passes laid greedily as in the paper, or densely, without gaps. Default: the case's, else greedy."
        ),
    ] = None,
    size_mm: SizeMm = None,
    up: Up = "+z",
    depth_mm: DepthMm = None,
    flattening: Annotated[
        Literal["arap", "grid"] | None,
        Parameter(help="As rigid as possible, or the paper's grid blocks (Fig. 5). Default: the case's, else arap."),
    ] = None,
    calibration: Annotated[Path | None, Parameter(help="Calibration (.toml). Default: a placeholder.")] = None,
    machine: Annotated[Path | None, Parameter(help="Machine (.toml). Default: the paper's.")] = None,
    layers_mm: Annotated[
        str, Parameter(help="Thickness of each layer, bottom first [mm]: the lower half bends convex.")
    ] = "0.2,0.2,0.2,0.2",
    margin_mm: Annotated[
        float | None, Parameter(help="Unaligned film left around the pattern [mm]. Default: the case's, else 0.")
    ] = None,
    seed: Annotated[
        int | None,
        Parameter(
            help="Seed of the random starts of the passes. Default: the case's, else 0.", validator=Number(gte=0)
        ),
    ] = None,
    inverse: InverseFlags | None = None,
    heating: DesignHeatingFlags | None = None,
    material: DesignMaterialFlags | None = None,
    noise: DesignNoiseFlags | None = None,
) -> None:
    """Plan the passes for a target: writes program.json, plan.json, plan.png and the target.

    The inverse method designs for the film as it will be heated, of the material that it is made of; the groups
    below are for it alone. While it searches, OUT.progress/current.png shows the present shape; in the end,
    progress.png the way there and design.png what is predicted.
    """
    from scenes.commands import run_plan

    run_plan(
        target,
        out,
        method=method,
        tracer=tracer,
        size_mm=size_mm,
        up=up,
        depth_mm=depth_mm,
        flattening=flattening,
        calibration=calibration,
        machine=machine,
        layers_mm=layers_mm,
        margin_mm=margin_mm,
        seed=seed,
        inverse=inverse or InverseFlags(),
        heating=heating or DesignHeatingFlags(),
        material=material or DesignMaterialFlags(),
        noise=noise or DesignNoiseFlags(),
    )


@app.command
def predict(
    program: Annotated[Path, Parameter(help="Program file, a plan's or a run's folder, or an as-run.jsonl.")],
    *,
    out: Out,
    target: Annotated[str | None, Parameter(help="Score against this target. Default: the plan's own.")] = None,
    scanner_noise: Annotated[bool, Parameter(help="See the shape through a phone's depth camera.")] = False,
    calibration_draws: Annotated[
        int,
        Parameter(
            help="Where the calibration is measured: heat this many films on a mesh of 1.2 mm, each with a map of load "
            "and speed that its strips leave possible, and tell how far the score is open; 0 for none.",
            validator=Number(gte=0, lte=1000),
        ),
    ] = 8,
    heating: HeatingFlags | None = None,
    material: MaterialFlags | None = None,
    post: PostFlags | None = None,
    solver: SolverFlags | None = None,
    noise: NoiseFlags | None = None,
) -> None:
    """Predict the hot shape of a Program, or of a film as run: writes result.json, shapes, pictures and report.html."""
    from scenes.commands import run_predict

    run_predict(
        program,
        out,
        target=target,
        scanner_noise=scanner_noise,
        calibration_draws=calibration_draws,
        heating=heating or HeatingFlags(),
        material=material or MaterialFlags(),
        post=post or PostFlags(),
        solver=solver or SolverFlags(),
        noise=noise or NoiseFlags(),
    )


@app.command
def run(
    program: Annotated[Path, Parameter(help="Program file, or a plan's folder.")],
    *,
    out: Annotated[Path, Parameter(help="Folder for journal, as-run log, wire logs and run.json; made if absent.")],
    rig: Annotated[Path | None, Parameter(help="Rig (.toml): machine and ports. Default: a simulated one.")] = None,
    dry_run: Annotated[
        bool, Parameter(help="Print every operation and every line with its time instead, on no port at all.")
    ] = False,
    resume: Annotated[bool, Parameter(help="Go on with the run in OUT after a crash, a stop or a lost port.")] = False,
    score: Annotated[
        bool, Parameter(help="In the end predict the film as run, against the plan's own target if there is one.")
    ] = True,
) -> None:
    """Run a Program on a rig: scratch the film, and say what was done.

    Ctrl-C pauses at the next safe point, a second one stops at once. Neither is an emergency stop.
    """
    from scenes.running import run_program

    run_program(program, out, rig=rig, dry_run=dry_run, resume=resume, score=score)


@app.command
def score(
    scan: Annotated[Path, Parameter(help="Scan of a real film (.stl .ply .obj .xyz .npz) [mm].")],
    *,
    target: TargetText,
    out: Out,
    size_mm: SizeMm = None,
    up: Up = "+z",
    depth_mm: DepthMm = None,
) -> None:
    """Score a scan against a target: writes result.json and pictures."""
    from scenes.commands import run_score

    run_score(scan, out, target=target, size_mm=size_mm, up=up, depth_mm=depth_mm)


@app.command
def calibrate(
    strips: Annotated[
        Path,
        Parameter(
            help="Measured strips (.csv) with the columns load_g, speed_mm_s, radius_mm, side (bottom or top), "
            "width_mm and repeat, in any order."
        ),
    ],
    *,
    out: Annotated[Path, Parameter(help="Calibration to write (.toml); its picture (.png) is written beside it.")],
    name: Annotated[str | None, Parameter(help="Name of the calibration. Default: that of the strips' file.")] = None,
    operator: Annotated[str | None, Parameter(help="Who made and measured the strips, for the record.")] = None,
    date: Annotated[str | None, Parameter(help="When they were measured, for the record. Default: today.")] = None,
    method: Annotated[str | None, Parameter(help="How radii were measured, for the record.")] = None,
    layers_mm: Annotated[
        str, Parameter(help="Thickness of each layer of the strips, bottom first [mm]: the lower half was scratched.")
    ] = "0.2,0.2,0.2,0.2",
) -> None:
    """Fit load and speed to bending radius by measured strips: writes a calibration for `lce plan`.

    The radius falls with load, saturates, and grows with speed: a curve of that form with a smooth deviation is fitted
    to the strips, with a band for the whole map; strips that do not belong to it are named and left out.
    """
    from scenes.commands import run_calibrate

    run_calibrate(strips, out, name=name, operator=operator, date=date, method=method, layers_mm=layers_mm)


@app.command
def export(
    source: Annotated[Path, Parameter(help="A plan's or a prediction's folder, or a Program file.")],
    *,
    out: Out,
) -> None:
    """Export for other programs: layers as SVG, DXF and G-code preview, hot shape as STL, PLY and VTP, images, tables.

    What is written is what the source holds: a plan gives layers (in mm) and passes (CSV, NPZ), a prediction the hot
    shape, its numbers (CSV, NPZ) and depth images (16-bit PNG, their scale in depth.json).
    """
    from scenes.commands import run_export

    run_export(source, out)


@app.command
def film(
    prediction: Annotated[Path, Parameter(help="Folder of a prediction.")],
    *,
    out: Annotated[
        Path,
        Parameter(
            help="Film (.mp4, needs the extra `film`; .gif), strip of a few shapes side by side (.png), or folder for "
            "pictures."
        ),
    ],
    frames: Annotated[
        int | None,
        Parameter(
            help="Number of pictures, 25 a second. Default: 150, of a strip 6.", validator=Number(gte=2, lte=2000)
        ),
    ] = None,
) -> None:
    """Film the sheet of a prediction as it is heated and rises."""
    from scenes.commands import run_film

    run_film(prediction, out, frames=frames)


@app.command
def studio(
    *,
    workspace: Annotated[
        Path, Parameter(help="Folder of runs and uploaded files; made if absent. One studio at a time.")
    ] = Path("out/studio"),
    port: Annotated[
        int, Parameter(help="Port of 127.0.0.1 to listen on; 0 for any free one.", validator=Number(gte=0, lte=65_535))
    ] = 0,
    at_once: Annotated[
        int, Parameter(help="So many runs at the same time; others wait.", validator=Number(gte=1, lte=64))
    ] = 1,
    browser: Annotated[bool, Parameter(help="Open the page in your browser.")] = True,
) -> None:
    """Open a local page to plan, predict and compare: prints its address, which has a token in it.

    Only browsers of this machine that have the address are let in. Runs go on when the page is closed; their results
    stay in the workspace. Needs the extra `studio`. Ctrl-C closes it and cancels what runs.
    """
    from scenes.studio.serve import run_studio

    run_studio(workspace, port=port, at_once=at_once, browser=browser)


@app.command
def doctor() -> None:
    """Say what was found on this machine: versions, devices, solver, kernel cache, display, OpenGL, serial ports."""
    from scenes.doctor import print_findings

    print_findings()


@app.command
def schema() -> None:
    """Print the JSON schema of program.json."""
    import json

    from planner.program import program_schema

    sys.stdout.write(json.dumps(program_schema(), indent=2) + "\n")


def main() -> None:
    """Run the command line; exit code 0 done, 2 wrong input, 3 rig failed, 1 anything else."""
    try:
        app(sys.argv[1:], exit_on_error=False, print_error=False)
    except CycloptsError as error:
        command = " ".join(("lce", *(error.command_chain or ())))
        _fail(f"{str(error).rstrip('.')}; see `{command} --help`.", exit_code=InputError.exit_code)
    except InputError as error:
        _fail(*error.problems, exit_code=error.exit_code)
    except LceError as error:
        _fail(str(error), exit_code=error.exit_code)
    except KeyboardInterrupt:
        _fail("interrupted; no results were written.", exit_code=130)


def _fail(*problems: str, exit_code: int) -> NoReturn:
    """Write one line for each problem to stderr, and leave."""
    sys.stderr.writelines(f"lce: {problem}\n" for problem in problems)
    sys.exit(exit_code)


if __name__ == "__main__":
    main()
