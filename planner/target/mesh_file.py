"""Meshes and point clouds as files hold them: checked vertices, and triangles where there are any."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from planner.errors import InputError

MESH_SUFFIXES = (".stl", ".obj", ".ply", ".glb", ".off")
"""Formats that trimesh reads for us."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FileGeometry:
    """What a mesh or cloud file holds, in the axes of the file."""

    vertices: np.ndarray
    """Vertices in the unit of the file, shape [n, 3]."""
    triangles: np.ndarray
    """Vertex indices, shape [m, 3]; empty for a point cloud."""
    notes: tuple[str, ...]
    """What was mended while reading."""


def read_mesh_file(path: Path, *, name: str) -> FileGeometry:
    """Read a mesh, or the points of a file without triangles.

    Several parts are joined. Vertices at the same place become one, triangles that occur twice or have no area
    are dropped. The axes are taken as stored, also from .glb, whose models stand upright along y and face +z.

    Raises:
        InputError: The file cannot be read, is empty, or has vertices that are not numbers.
    """
    try:
        scene = trimesh.load_scene(path, process=False)
        parts = scene.dump()
    except Exception as error:  # the readers behind trimesh raise whatever they meet
        raise InputError(
            f"{name}: {path} cannot be read as {path.suffix} ({type(error).__name__}: {error}); "
            "export it again, for example as binary .stl."
        ) from error
    solids = [part for part in parts if isinstance(part, trimesh.Trimesh) and len(part.faces)]
    clouds = [part for part in parts if isinstance(part, trimesh.PointCloud | trimesh.Trimesh)]
    vertices, triangles, start = [], [np.empty((0, 3), dtype=np.int64)], 0
    for part in solids or clouds:
        vertices.append(np.asarray(part.vertices, dtype=float).reshape(-1, 3))
        if isinstance(part, trimesh.Trimesh):
            triangles.append(np.asarray(part.faces, dtype=np.int64).reshape(-1, 3) + start)
        start += len(vertices[-1])
    if start == 0:
        raise InputError(f"{name}: {path} holds no triangles and no points; export the surface again.")
    return _clean(np.vstack(vertices), np.vstack(triangles), path, name)


def _clean(vertices: np.ndarray, triangles: np.ndarray, path: Path, name: str) -> FileGeometry:
    """Join equal vertices and drop triangles that say nothing."""
    bad = ~np.isfinite(vertices).all(axis=1)
    if len(triangles) == 0:
        return FileGeometry(vertices=vertices, triangles=triangles, notes=())
    if bad.any():
        raise InputError(
            f"{name}: {bad.sum()} of {len(vertices)} vertices in {path} are NaN or infinite, the first is vertex "
            f"{int(np.argmax(bad))}; give finite coordinates, or remove those vertices."
        )
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise InputError(
            f"{name}: triangles in {path} refer to vertex {triangles.max()} of {len(vertices)}; export it again."
        )
    used = np.unique(triangles)
    distinct, place = np.unique(vertices[used], axis=0, return_inverse=True)
    renumber = np.zeros(len(vertices), dtype=np.int64)
    renumber[used] = place.ravel()
    triangles = renumber[triangles]
    corners = distinct[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    solid = np.linalg.norm(normal, axis=1) > 0
    single = np.zeros(len(triangles), dtype=bool)
    single[np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)[1]] = True
    kept = solid & single
    if not kept.any():
        raise InputError(f"{name}: no triangle in {path} has an area; export the surface again.")
    doubled = int((solid & ~single).sum())
    notes = (f"{doubled} triangles that occurred twice were dropped.",) if doubled else ()
    return FileGeometry(vertices=distinct, triangles=triangles[kept], notes=notes)
