"""Dense toolpaths: lines of one width that tile what is to be scratched, along a smooth director field."""

from planner.toolpaths.dense.director_field import DirectorField, Reading
from planner.toolpaths.dense.lines import LEAST, dense_lines
from planner.toolpaths.dense.mesh_field import MeshField
from planner.toolpaths.dense.tiling import Tiling, tiling

__all__ = ["LEAST", "DirectorField", "MeshField", "Reading", "Tiling", "dense_lines", "tiling"]
