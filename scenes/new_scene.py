"""A scene file to start from: a built-in case with a comment on every key."""

import json
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from planner.errors import InputError
from scenes.case import Case, list_cases, load_case
from scenes.whole_file import whole_file

DEFAULT = "oblate_dome"
COMMENTS = {
    "name": "how the plan and its pictures are called",
    "description": "one line that `lce scenes` would show",
    "kind": "dome, sphere_cap, saddle, ridge, two_bump, face or strip; each has its own lengths",
    "radius_mm": "radius [mm]",
    "height_mm": "height; of a face its length from chin to brow [mm]",
    "width_mm": "width [mm]",
    "length_mm": "length [mm]",
    "cut": "share of the radius at which the dome is cut off, 0 to 1: 1 is half an ellipsoid with upright walls",
    "edge_radius_mm": "radius of the round outline, seen from above [mm]",
    "end_mm": "length over which each end runs out softly [mm]",
    "bump_mm": "height of the dome and depth of the hollow beside it [mm]",
    "spread_mm": "how wide each of them is [mm]",
    "contraction": "of the bottom two of four layers, 0 to 0.6, instead of radius_mm",
    "method": "perpendicular or maximum, the paper's two; `lce plan --method inverse` searches all layers",
    "flattening": "arap, as rigid as possible, or grid, the paper's blocks",
    "tracer": "greedy as in the paper, or dense, without gaps",
    "margin_mm": "unaligned film left around the pattern [mm]",
    "seed": "of the random choices: the same seed gives the same result",
    "mesh_mm": "edge of the simulated film's triangles [mm]",
    "temperature_c": "of the hot plate [C]",
    "support": "plate: lying on it under its own weight; free: weightless",
}
TABLES = {
    "target": "What the hot film should become; x to the right, y up, z out of the plate.",
    "plan": "How passes are laid: `lce plan SCENE.toml --out out/plan`. Flags given there win over this file.",
    "predict": "How the demo predicts it. `lce predict` takes its own flags.",
}


def scene_text(case: Case, name: str) -> str:
    """Return a case as a scene file named `name`, every key of it commented."""
    parts = [
        "# A scene: run `lce plan` on this file as it is, or change it first. Lengths in mm.\n",
        _line("name", name),
        _line("description", case.description),
    ]
    for table, comment in TABLES.items():
        part: BaseModel = getattr(case, table)
        parts.append(f"\n# {comment}\n[{table}]\n")
        parts += [_line(key, value) for key, value in part.model_dump().items() if value is not None]
    return "".join(parts)


def write_new_scene(scene: str, like: str | None) -> Path:
    """Write a scene file and return its path.

    Args:
        scene: name of the scene, or path of the file to write (.toml).
        like: built-in case to start from; None for the one that is called like the scene, else a dome.

    Raises:
        InputError: if there is no such case, the file is already there, or it cannot be written.
    """
    path = Path(scene if scene.endswith(".toml") else f"{scene}.toml")
    name = path.stem
    if not name or name.startswith("."):
        raise InputError(f"scene: found {scene!r}, allowed is a name or a file that ends in .toml; write my_dome.")
    known = {case.name for case in list_cases()}
    case = load_case(like or (name if name in known else DEFAULT))
    if path.exists():
        raise InputError(f"{path}: is already there and is not overwritten; choose another name or move it.")
    try:
        with whole_file(path) as scratch:
            scratch.write_text(scene_text(case, name), encoding="utf-8")
    except OSError as error:
        raise InputError(
            f"{path}: cannot be written ({error.strerror or error}); name a folder that exists and can be written."
        ) from error
    return path


def _line(key: str, value: Any) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return f"{f'{key} = {text}':<28} # {COMMENTS[key]}\n"
