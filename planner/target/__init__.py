"""The target room: surfaces from files and formulas, as height fields with a smooth outline."""

from planner.target.height_map_file import save_target
from planner.target.heights import target_from_heights
from planner.target.load import TARGET_SUFFIXES, load_target
from planner.target.outline import signed_area
from planner.target.planar_mesh import mesh_outline
from planner.target.sampling import sample_surface
from planner.target.surface import Surface
from planner.target.surface_mesh import surface_mesh
from planner.target.target import Target

__all__ = [
    "TARGET_SUFFIXES",
    "Surface",
    "Target",
    "load_target",
    "mesh_outline",
    "sample_surface",
    "save_target",
    "signed_area",
    "surface_mesh",
    "target_from_heights",
]
