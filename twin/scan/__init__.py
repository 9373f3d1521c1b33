"""Scan: how a shape is seen from above, read from a file, and laid over its target."""

from twin.scan.closest import ClosestPoints, grid_triangles, target_surface
from twin.scan.depth_image import SHAPE_PX, depth_image, grey_image, pixel_centres, pixel_weights, target_depth_image
from twin.scan.gridding import grid_points
from twin.scan.reading import read_scan
from twin.scan.registration import register
from twin.scan.rigid import RigidTransform
from twin.scan.scan import Scan
from twin.scan.scanner import Scanner

__all__ = [
    "SHAPE_PX",
    "ClosestPoints",
    "RigidTransform",
    "Scan",
    "Scanner",
    "depth_image",
    "grey_image",
    "grid_points",
    "grid_triangles",
    "pixel_centres",
    "pixel_weights",
    "read_scan",
    "register",
    "target_depth_image",
    "target_surface",
]
