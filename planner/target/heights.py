"""The one constructor of targets: from heights over a grid to a centred, outlined, validated Target."""

from collections.abc import Iterable

import numpy as np

from planner.errors import InputError
from planner.target.footprint import BLEMISH_SHARE, mend_footprint
from planner.target.local_planes import fill_heights
from planner.target.outline import region_outlines, signed_area, signed_distance
from planner.target.target import Target

FEWEST_NODES = 6
"""A surface narrower than this many grid nodes has no curvature to speak of."""
FLATTEST_MM = 0.01
"""Depth below which a surface counts as constant [mm]."""
UNEVENNESS = 1e-3
"""Largest accepted deviation of a grid line from even spacing [cells]; float32 files stay below it."""
CLEARANCE_CELLS = 1.5
"""Distance to the outline within which nodes are neither dropped nor filled [cells]."""


def target_from_heights(
    name: str, x_mm: np.ndarray, y_mm: np.ndarray, z_mm: np.ndarray, notes: Iterable[str] = ()
) -> Target:
    """Make a target of heights over a regular grid: mend, outline, centre and validate it.

    Args:
        name: Shown in reports and messages.
        x_mm: Grid columns [mm], evenly spaced, shape [nx].
        y_mm: Grid rows [mm], evenly spaced, shape [ny].
        z_mm: Heights [mm], NaN outside the surface, shape [ny, nx].
        notes: What the user should know about how the surface was read.

    Raises:
        InputError: The grid is malformed, constant, infinite, in pieces, or has holes.

    """
    x, y, z = check_grid(name, x_mm, y_mm, z_mm)
    spacing = (float(x[1] - x[0]), float(y[1] - y[0]))
    footprint = mend_footprint(np.isfinite(z), x, y, name=name)
    problems = list(footprint.problems)
    outlines = region_outlines(footprint.inside, x, y)
    if not outlines:
        problems.append(
            f"{name}: the surface is a strip about one grid cell wide; give it at least {FEWEST_NODES} cells."
        )
    elif len(outlines) > 1 and signed_area(outlines[1]) > BLEMISH_SHARE * signed_area(outlines[0]):
        problems.append(
            f"{name}: {len(outlines)} parts of the surface hang together by strips about one grid cell wide; "
            "widen the strips, refine the grid, or keep one part."
        )
    if problems:
        raise InputError(problems)

    outline = outlines[0]
    nodes = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    cells_inside = signed_distance(nodes, outline).reshape(z.shape) / max(spacing)
    # Nodes near the outline keep what the source says, known or not: continuing the surface there
    # would move its lowest point.
    kept = (cells_inside > CLEARANCE_CELLS) | (footprint.inside & (cells_inside >= -CLEARANCE_CELLS))
    z = fill_heights(np.where(footprint.inside, z, np.nan), kept, spacing_mm=spacing)
    z = np.where(kept, z, np.nan)
    if np.nanmax(z) - np.nanmin(z) < FLATTEST_MM:
        raise InputError(
            f"{name}: the surface is constant (all heights within {FLATTEST_MM} mm of "
            f"{np.nanmin(z):.4g} mm); a target needs relief: check the file, its up direction and its units."
        )
    middle = 0.5 * (outline.min(axis=0) + outline.max(axis=0))
    return Target(
        name=name,
        x_mm=x - middle[0],
        y_mm=y - middle[1],
        z_mm=z - np.nanmin(z),
        outline_mm=outline - middle,
        notes=(*notes, *footprint.notes),
    )


def check_grid(
    name: str, x_mm: np.ndarray, y_mm: np.ndarray, z_mm: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Check shapes, spacing and numbers of a grid, and turn its axes so that they ascend."""
    x, y, z = (np.asarray(array, dtype=float) for array in (x_mm, y_mm, z_mm))
    problems = []
    if x.ndim != 1 or y.ndim != 1 or z.shape != (y.size, x.size):
        raise InputError(
            f"{name}: x_mm has shape {x.shape}, y_mm {y.shape} and z_mm {z.shape}; "
            "allowed are (nx,), (ny,) and (ny, nx): one row of heights for each y."
        )
    if min(z.shape) < FEWEST_NODES:
        raise InputError(
            f"{name}: the grid has {x.size} columns and {y.size} rows; "
            f"at least {FEWEST_NODES} of each are needed: give the surface on a finer grid."
        )
    if x[0] > x[-1]:
        x, z = x[::-1], z[:, ::-1]
    if y[0] > y[-1]:
        y, z = y[::-1], z[::-1]
    for axis, values in (("x_mm", x), ("y_mm", y)):
        even = np.linspace(values[0], values[-1], values.size)
        if not np.isfinite(values).all():
            problems.append(
                f"{name}: {axis} holds {np.sum(~np.isfinite(values))} NaN or infinite values; give numbers in mm."
            )
        elif not values[-1] > values[0] or np.abs(values - even).max() > UNEVENNESS * (even[1] - even[0]):
            worst = int(np.argmax(np.abs(values - even)))
            problems.append(
                f"{name}: {axis} is not evenly spaced (entry {worst} is {values[worst]:.6g} mm, "
                f"even spacing asks for {even[worst]:.6g} mm); resample the heights onto an even grid."
            )
    if np.isinf(z).any():
        row, column = np.argwhere(np.isinf(z))[0]
        problems.append(
            f"{name}: z_mm holds {np.isinf(z).sum()} infinite values, the first in row {row}, "
            f"column {column}; allowed are heights in mm, and NaN outside the surface."
        )
    elif np.isnan(z).all():
        problems.append(f"{name}: z_mm is NaN everywhere; give heights in mm on the surface.")
    if problems:
        raise InputError(problems)
    return np.linspace(x[0], x[-1], x.size), np.linspace(y[0], y[-1], y.size), z
