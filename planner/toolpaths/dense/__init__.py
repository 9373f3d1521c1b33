"""Dense toolpaths: lines of one width that tile what is to be scratched, along a smooth director field."""

from planner.toolpaths.dense.cloud_field import CLOUD_LEAST, CloudField, cloud_field
from planner.toolpaths.dense.director_field import DirectorField, Reading
from planner.toolpaths.dense.lines import LEAST, dense_lines
from planner.toolpaths.dense.mesh_field import MeshField
from planner.toolpaths.dense.tiling import Tiling, tiling
from planner.toolpaths.dense.trace_dense import trace_dense

__all__ = [
    "CLOUD_LEAST",
    "LEAST",
    "CloudField",
    "DirectorField",
    "MeshField",
    "Reading",
    "Tiling",
    "cloud_field",
    "dense_lines",
    "tiling",
    "trace_dense",
]
