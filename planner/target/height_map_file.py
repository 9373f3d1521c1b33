"""Height maps and saved targets in .npz files."""

import os
import zipfile
from pathlib import Path

import numpy as np

from planner.errors import InputError
from planner.target.coarsen import coarsen
from planner.target.heights import check_grid
from planner.target.mesh_heights import GridHeights
from planner.target.outline import loop_length, signed_area, signed_distance
from planner.target.target import Target

GRID_KEYS = ("x_mm", "y_mm", "z_mm")
"""Arrays that make a height map; other arrays in the file are ignored, but for those of a saved target."""


def read_height_map(path: Path, *, name: str) -> GridHeights | Target:
    """Read heights over a grid; a target that this program saved comes back exactly as it was.

    Raises:
        InputError: The file is no .npz, or its arrays are missing, not numbers, or do not fit together.
    """
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays = {key: archive[key] for key in archive.files}
    except (OSError, ValueError, TypeError, EOFError, AttributeError, zipfile.BadZipFile) as error:
        raise InputError(
            f"{name}: {path} cannot be read as .npz ({error}); write it with numpy.savez and the arrays "
            f"{', '.join(GRID_KEYS)}."
        ) from error
    problems = [
        f"{name}: {path} has no array {key} (it has {', '.join(arrays) or 'none'}); add it in mm."
        for key in GRID_KEYS
        if key not in arrays
    ]
    problems += [
        f"{name}: {key} in {path} is of type {arrays[key].dtype}; give real numbers in mm."
        for key in (*GRID_KEYS, "outline_mm")
        if key in arrays and arrays[key].dtype.kind not in "iuf"
    ]
    if problems:
        raise InputError(problems)
    x, y, z = check_grid(name, *(arrays[key] for key in GRID_KEYS))
    if "outline_mm" in arrays:
        return _saved_target(arrays, path, name)
    x, y, z = coarsen(x, y, z)
    return GridHeights(x_mm=x, y_mm=y, z_mm=z)


def save_target(target: Target, path: Path | str) -> None:
    """Write a target to an .npz file, whole or not at all.

    Raises:
        InputError: The name does not end in .npz, or the folder cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() != ".npz":
        raise InputError(f"target: {path} cannot hold a saved target; choose a name that ends in .npz.")
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with part.open("wb") as file:
            np.savez_compressed(
                file,
                x_mm=target.x_mm,
                y_mm=target.y_mm,
                z_mm=target.z_mm,
                outline_mm=target.outline_mm,
                name=np.array(target.name),
                notes=np.array(target.notes, dtype=np.str_),
            )
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise InputError(
            f"target: {path} cannot be written ({error.strerror or error}); choose another folder."
        ) from error


def _saved_target(arrays: dict[str, np.ndarray], path: Path, name: str) -> Target:
    """Rebuild a saved target, provided that its outline still belongs to its heights."""
    outline = np.asarray(arrays["outline_mm"], dtype=float)
    x, y, z = (np.asarray(arrays[key], dtype=float) for key in GRID_KEYS)
    fits = outline.ndim == 2 and outline.shape[1:] == (2,) and len(outline) >= 8 and np.isfinite(outline).all()
    if fits:
        cell = max(x[1] - x[0], y[1] - y[0])
        rows, columns = np.nonzero(np.isfinite(z))
        stray = signed_distance(np.column_stack((x[columns], y[rows])), outline).min()
        area = len(rows) * (x[1] - x[0]) * (y[1] - y[0])
        fits = stray > -2.0 * cell and abs(signed_area(outline) - area) < 2.0 * cell * loop_length(outline)
    if not fits:
        raise InputError(
            f"{name}: outline_mm in {path} (shape {outline.shape}) does not run around the heights, "
            "counter-clockwise; leave the array out, and the outline is found again."
        )
    return Target(
        name=str(arrays.get("name", name)),
        x_mm=x,
        y_mm=y,
        z_mm=z,
        outline_mm=outline,
        notes=tuple(str(note) for note in np.atleast_1d(arrays.get("notes", ()))),
    )
