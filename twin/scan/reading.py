"""Scan files: meshes, point clouds and height grids."""

from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from planner.errors import InputError
from twin.scan.closest import grid_triangles
from twin.scan.scan import Scan

SUFFIXES = (".stl", ".ply", ".obj", ".xyz", ".npz")
SMALLEST_MM, LARGEST_MM = 2.0, 300.0
"""Largest extents that a scan of a film can have [mm]; beyond them the units are wrong."""
FEWEST_POINTS = 100


def read_scan(path: str | Path) -> Scan:
    """Read a scan of an actuated film.

    Meshes and clouds come from `.stl`, `.ply`, `.obj` (with or without faces) and `.xyz` (three numbers a line,
    further columns ignored); `.npz` holds a height grid `x_mm`, `y_mm`, `z_mm` with NaN outside, or
    `vertices_mm` with or without `triangles`. Lengths are mm.

    Raises:
        InputError: The file is missing, of another kind, empty, damaged, or plainly in other units.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: no such file; give a scan file ({', '.join(SUFFIXES)}).")
    readers = {".npz": _read_npz, ".xyz": _read_xyz}
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError(
            f"{path}: the suffix {suffix or '(none)'} is no scan format; allowed are {', '.join(SUFFIXES)}: "
            "export the scan as one of them."
        )
    try:
        vertices, triangles = readers.get(suffix, _read_mesh)(path)
    except InputError:
        raise
    except Exception as error:  # the parsers raise whatever they stumble over
        raise InputError(
            f"{path}: cannot be read as {suffix} ({type(error).__name__}: {error}); export the scan again."
        ) from error
    return _checked(path, vertices, triangles)


def _read_mesh(path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    loaded: Any = trimesh.load(path, process=False)
    parts = list(loaded.geometry.values()) if isinstance(loaded, trimesh.Scene) else [loaded]
    vertices, triangles, count = [], [], 0
    for part in parts:
        vertices.append(np.asarray(part.vertices, dtype=float).reshape(-1, 3))
        triangles.append(np.asarray(getattr(part, "faces", np.empty((0, 3))), dtype=np.int64).reshape(-1, 3) + count)
        count += len(vertices[-1])
    if not count and path.suffix.lower() == ".obj":
        # A phone's scan app writes bare `v x y z` lines.
        lines = path.read_text(errors="replace").splitlines()
        vertices = [np.array([line.split()[1:4] for line in lines if line.startswith("v ")], dtype=float)]
    points = np.concatenate(vertices) if vertices else np.empty((0, 3))
    faces = np.concatenate(triangles) if triangles else np.empty((0, 3), dtype=np.int64)
    return points.reshape(-1, 3), faces if len(faces) else None


def _read_xyz(path: Path) -> tuple[np.ndarray, None]:
    return np.loadtxt(path, usecols=(0, 1, 2), ndmin=2, comments="#"), None


def _read_npz(path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    with np.load(path, allow_pickle=False) as data:
        if "vertices_mm" in data:
            triangles = np.asarray(data["triangles"], dtype=np.int64) if "triangles" in data else None
            return np.asarray(data["vertices_mm"], dtype=float), triangles
        missing = [key for key in ("x_mm", "y_mm", "z_mm") if key not in data]
        if missing:
            raise InputError(
                f"{path}: holds {', '.join(data.files) or 'nothing'} but not {', '.join(missing)}; "
                "give a height grid x_mm, y_mm, z_mm, or vertices_mm with or without triangles."
            )
        x, y, z = (np.asarray(data[key], dtype=float) for key in ("x_mm", "y_mm", "z_mm"))
    if z.shape != (y.size, x.size):
        raise InputError(f"{path}: z_mm has shape {z.shape}, allowed is (y, x) = {(y.size, x.size)}.")
    return grid_triangles(x.ravel(), y.ravel(), z)


def _checked(path: Path, vertices: np.ndarray, triangles: np.ndarray | None) -> Scan:
    """Drop points that are no numbers and refuse what cannot be a scan of a film."""
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise InputError(f"{path}: the points have shape {vertices.shape}, allowed is (n, 3): x, y, z in mm.")
    if triangles is not None and (
        triangles.ndim != 2 or triangles.shape[1] != 3 or triangles.min() < 0 or triangles.max() >= len(vertices)
    ):
        raise InputError(
            f"{path}: the triangles have shape {triangles.shape} and name vertices {triangles.min()} to "
            f"{triangles.max()}, allowed are (m, 3) and 0 to {len(vertices) - 1}; export the scan again."
        )
    notes = []
    finite = np.asarray(np.isfinite(vertices).all(axis=1))
    if not finite.all():
        notes.append(f"{path.name}: {np.sum(~finite)} points with NaN or infinite coordinates were left out.")
        if triangles is not None:
            triangles = triangles[finite[triangles].all(axis=1)]
            triangles = (np.cumsum(finite) - 1)[triangles]
        vertices = vertices[finite]
    if len(vertices) < FEWEST_POINTS:
        raise InputError(
            f"{path}: has {len(vertices)} points, at least {FEWEST_POINTS} are needed; export the scan again."
        )
    extent = float(np.ptp(vertices, axis=0).max())
    if not SMALLEST_MM <= extent <= LARGEST_MM:
        hint = "it looks like metres: scale it by 1000" if 1e3 * extent <= LARGEST_MM else "scale it to mm"
        raise InputError(
            f"{path}: the scan is {extent:.4g} mm wide, allowed are {SMALLEST_MM:g} to {LARGEST_MM:g} mm; {hint}."
        )
    return Scan(vertices_mm=vertices, triangles=triangles, notes=tuple(notes))
