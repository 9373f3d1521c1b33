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
from scenes.noise_flags import NoiseFlags
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
    )


@app.command
def predict(
    program: Annotated[Path, Parameter(help="Program file, a plan's folder, or the as-run.jsonl of a run.")],
    *,
    out: Out,
    target: Annotated[str | None, Parameter(help="Score against this target. Default: the plan's own.")] = None,
    scanner_noise: Annotated[bool, Parameter(help="See the shape through a phone's depth camera.")] = False,
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
def doctor() -> None:
    """Say what was found on this machine: versions, devices, solver, kernel cache, display."""
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
