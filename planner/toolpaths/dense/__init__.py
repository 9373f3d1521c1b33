"""Dense toolpaths: lines of one width that tile what is to be scratched, along a smooth director field."""

from planner.toolpaths.dense.lines import LEAST, dense_lines
from planner.toolpaths.dense.tiling import Tiling, tiling

__all__ = ["LEAST", "Tiling", "dense_lines", "tiling"]
