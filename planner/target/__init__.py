"""The target room: surfaces from files and formulas, as height fields with a smooth outline."""

from planner.target.heights import target_from_heights
from planner.target.planar_mesh import mesh_outline
from planner.target.surface import Surface
from planner.target.surface_mesh import surface_mesh
from planner.target.target import Target

__all__ = ["Surface", "Target", "mesh_outline", "surface_mesh", "target_from_heights"]
