"""Export what a folder holds: a plan, a prediction, or both."""

import json
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
import trimesh

from planner.errors import InputError
from planner.program import PROGRAM_FILE, Program, load_program
from scenes.exports.depth import write_depth_images
from scenes.exports.dxf import write_layer_dxfs
from scenes.exports.gcode import write_layer_gcodes
from scenes.exports.shape import write_shape
from scenes.exports.svg import write_layer_svgs
from scenes.exports.tables import write_pass_tables, write_result_tables
from scenes.output import output_folder

RESULT_FILE, SHAPE_FILE, SCAN_FILE = "result.json", "shape.ply", "scan.npz"


def export_into(folder: Path, source: Path) -> tuple[str, ...]:
    """Export a Program file, or all that a plan's or a prediction's folder holds, into `folder`.

    A plan gives each layer as SVG, DXF and G-code preview, and its passes as CSV and NPZ; a prediction its hot shape as
    STL, PLY, VTP and NPZ, its numbers as CSV and, where it was scored, depth images as 16-bit PNG, CSV and NPZ.

    Returns:
        The names of the files.

    Raises:
        InputError: if there is nothing to export, a file cannot be read, or the folder cannot be written.
    """
    program, result, shape, scan = _read(source)
    with output_folder(folder) as scratch:
        if program is not None:
            write_layer_svgs(scratch, program)
            write_layer_dxfs(scratch, program)
            write_layer_gcodes(scratch, program)
            write_pass_tables(scratch, program)
        if shape is not None:
            write_shape(scratch, *shape)
        if result is not None:
            write_result_tables(scratch, result, scan)
        if scan is not None:
            write_depth_images(scratch, scan)
        return tuple(sorted(path.name for path in scratch.iterdir()))


def _read(
    source: Path,
) -> tuple[Program | None, dict[str, Any] | None, tuple[np.ndarray, np.ndarray] | None, dict[str, np.ndarray] | None]:
    """Return the Program, the result, the shape and the scan that lie at `source`, None for what does not."""
    if not source.is_dir():
        return load_program(source), None, None, None
    there = {name for name in (PROGRAM_FILE, RESULT_FILE, SHAPE_FILE, SCAN_FILE) if (source / name).is_file()}
    if not there:
        raise InputError(
            f"{source}: holds neither {PROGRAM_FILE} nor {RESULT_FILE}; name the folder of a plan or a prediction."
        )
    program = load_program(source) if PROGRAM_FILE in there else None
    path = source
    try:
        path = source / RESULT_FILE
        result = json.loads(path.read_text(encoding="utf-8")) if path.name in there else None
        path = source / SHAPE_FILE
        shape = None
        if path.name in there:
            mesh: Any = trimesh.load(path, process=False)
            shape = np.asarray(mesh.vertices), np.asarray(mesh.faces)
        path = source / SCAN_FILE
        scan = None
        if path.name in there:
            with path.open("rb") as file, np.load(file) as archive:
                scan = {name: archive[name] for name in ("x_mm", "y_mm", "z_mm", "target_z_mm", "ssim_map")}
    except (OSError, ValueError, KeyError, AttributeError, EOFError, BadZipFile) as error:
        raise InputError(f"{path}: cannot be read ({error}); predict again.") from error
    return program, result, shape, scan
