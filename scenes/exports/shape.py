"""The hot shape as a mesh of other programs."""

from pathlib import Path

import numpy as np
import trimesh


def write_shape(folder: Path, vertices_mm: np.ndarray, triangles: np.ndarray) -> None:
    """Write shape.stl, shape.ply, shape.vtp and shape.npz: vertices [mm], shape [n, 3], triangles, shape [m, 3].

    STL knows neither units nor shared vertices and keeps single precision; the others keep the mesh as it is.
    """
    import pyvista

    mesh = trimesh.Trimesh(vertices_mm, triangles, process=False)
    mesh.export(folder / "shape.stl")
    mesh.export(folder / "shape.ply")
    pyvista.PolyData.from_regular_faces(np.asarray(vertices_mm, dtype=float), triangles).save(folder / "shape.vtp")
    np.savez_compressed(folder / "shape.npz", vertices_mm=vertices_mm, triangles=triangles)
