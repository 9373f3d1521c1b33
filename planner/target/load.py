"""Targets from files of all formats."""

import logging
from dataclasses import replace
from pathlib import Path

import numpy as np

from planner.errors import InputError
from planner.target.height_map_file import read_height_map
from planner.target.heights import target_from_heights
from planner.target.image_file import IMAGE_SUFFIXES, read_image
from planner.target.mesh_file import MESH_SUFFIXES, FileGeometry, read_mesh_file
from planner.target.mesh_heights import GridHeights, mesh_heights
from planner.target.point_cloud import clean_cloud, cloud_heights, read_xyz
from planner.target.print_size import Size, fit_outline, print_scale, scale_note, scale_target
from planner.target.target import Target
from planner.target.up_axis import turn_up

HEIGHT_MAP_SUFFIXES = (".npz",)
CLOUD_SUFFIXES = (".xyz",)
TARGET_SUFFIXES = (*MESH_SUFFIXES, *CLOUD_SUFFIXES, *HEIGHT_MAP_SUFFIXES, *IMAGE_SUFFIXES)
"""All file names that `load_target` accepts end in one of these."""

logger = logging.getLogger(__name__)


def load_target(
    path: Path | str,
    *,
    size_mm: Size | None = None,
    up: str = "+z",
    depth_mm: float | None = None,
    name: str | None = None,
) -> Target:
    """Read a target surface from a mesh, a point cloud, a height map or a depth image.

    Lengths are taken as mm. Of meshes and clouds the top surface along `up` counts.

    Args:
        path: The file; its suffix tells the format.
        size_mm: Box (width, height) that the surface seen from above shall fill [mm]; all axes scale alike.
        up: Axis of the file that points up: +x, -x, +y, -y, +z or -z; meshes and clouds only. The axes of a .glb
            are taken as stored: its models face +z and stand along y, so a lying one (a terrain) needs +y.
        depth_mm: Height between darkest and brightest grey [mm]; images only.
        name: Name of the target; the file's stem by default.

    Raises:
        InputError: The file or an option is wrong; the message lists all problems found.
    """
    path = Path(path)
    suffix = _checked_suffix(path, up, depth_mm)
    label = name or path.stem
    if suffix in IMAGE_SUFFIXES:
        heights = read_image(path, size_mm=size_mm, depth_mm=depth_mm, name=label)
    elif suffix in HEIGHT_MAP_SUFFIXES:
        heights = read_height_map(path, name=label)
    else:
        heights = _from_geometry(path, suffix, size_mm, up, label)

    if isinstance(heights, Target):
        target = heights if name is None else replace(heights, name=name)
        factor = print_scale(target.size_mm, size_mm, name=label)
        target = replace(scale_target(target, factor), notes=(*target.notes, *scale_note(factor)))
    else:
        if suffix in HEIGHT_MAP_SUFFIXES:
            heights = _scaled_grid(heights, size_mm, label)
        target = target_from_heights(label, heights.x_mm, heights.y_mm, heights.z_mm, heights.notes)
        if size_mm is not None:
            target = fit_outline(target, size_mm)
        if depth_mm is not None:
            target = replace(target, z_mm=target.z_mm * (depth_mm / target.depth_mm))
    for note in target.notes:
        logger.info("%s: %s", target.name, note)
    return target


def _checked_suffix(path: Path, up: str, depth_mm: float | None) -> str:
    """Check the file and the options that not all formats have; returns the suffix in lower case."""
    suffix = path.suffix.lower()
    allowed = ", ".join(TARGET_SUFFIXES)
    if path.is_dir():
        raise InputError(f"target: {path} is a folder; give a file that ends in one of {allowed}.")
    if not path.exists():
        raise InputError(f"target: there is no file {path}; check the path.")
    problems = []
    if suffix not in TARGET_SUFFIXES:
        problems.append(f"target: {path} ends in {suffix or 'nothing'!r}; allowed are {allowed}.")
    if path.stat().st_size == 0:
        problems.append(f"target: {path} is empty (0 bytes); export the surface again.")
    turnable = suffix in MESH_SUFFIXES or suffix in CLOUD_SUFFIXES
    if up != "+z" and suffix in TARGET_SUFFIXES and not turnable:
        problems.append(f"up: {up!r} is given for {path}, but a height map always has z up; leave it out.")
    if depth_mm is not None and suffix in TARGET_SUFFIXES and suffix not in IMAGE_SUFFIXES:
        problems.append(
            f"depth: {depth_mm:g} mm is given for {path}, but only images need a depth; leave it out, or set the "
            "size with --size-mm."
        )
    if problems:
        raise InputError(problems)
    return suffix


def _from_geometry(path: Path, suffix: str, size_mm: Size | None, up: str, name: str) -> GridHeights:
    """Read a mesh or a cloud, turn it up, scale it, and sample its top on a grid."""
    if suffix in CLOUD_SUFFIXES:
        geometry = FileGeometry(vertices=read_xyz(path, name=name), triangles=np.empty((0, 3), int), notes=())
    else:
        geometry = read_mesh_file(path, name=name)
    vertices, notes = geometry.vertices, geometry.notes
    if len(geometry.triangles) == 0:
        vertices, notes = clean_cloud(vertices, name=name)
    vertices = turn_up(vertices, up)
    extent = np.ptp(vertices[:, :2], axis=0)
    factor = print_scale((float(extent[0]), float(extent[1])), size_mm, name=name)
    vertices = vertices * factor
    heights = (
        mesh_heights(vertices, geometry.triangles, name=name)
        if len(geometry.triangles)
        else cloud_heights(vertices, name=name)
    )
    return replace(heights, notes=(*notes, *scale_note(factor), *heights.notes))


def _scaled_grid(heights: GridHeights, size_mm: Size | None, name: str) -> GridHeights:
    """Scale a height map to its print size."""
    present = np.isfinite(heights.z_mm)
    columns, rows = np.flatnonzero(present.any(axis=0)), np.flatnonzero(present.any(axis=1))
    extent = (float(np.ptp(heights.x_mm[columns])), float(np.ptp(heights.y_mm[rows])))
    factor = print_scale(extent, size_mm, name=name)
    return replace(
        heights,
        x_mm=heights.x_mm * factor,
        y_mm=heights.y_mm * factor,
        z_mm=heights.z_mm * factor,
        notes=(*heights.notes, *scale_note(factor)),
    )
