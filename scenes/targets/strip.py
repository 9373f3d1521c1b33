"""A calibration strip, bent: a patch of a cylinder."""

import numpy as np

from planner.target import Target, target_from_heights

_STEEPEST_RAD = np.deg2rad(65.0)
"""Slope at which the patch is cut: seen from above, a strip that curls farther hides itself."""
_COLUMNS = 120
"""Grid cells along the patch at least, so that small radii are resolved as well."""


def strip(*, length_mm: float, width_mm: float, radius_mm: float) -> Target:
    """Make the patch of a cylinder that a strip of this length bends to, curved along x.

    A strip that bends farther than 65 degrees to each side is cut there, with a note.

    Args:
        length_mm: Length of the flat strip [mm].
        width_mm: Width of the strip, along the cylinder's axis [mm].
        radius_mm: Bending radius [mm], convex seen from above.
    """
    angle = length_mm / (2.0 * radius_mm)
    notes = ()
    if angle > _STEEPEST_RAD:
        kept = 2.0 * radius_mm * _STEEPEST_RAD
        notes = (
            f"The strip of {length_mm:g} mm bends to {np.rad2deg(angle):.0f} degrees on each side at a radius of "
            f"{radius_mm:g} mm; the target shows its middle {kept:.1f} mm, up to 65 degrees.",
        )
        angle = _STEEPEST_RAD
    half = radius_mm * np.sin(angle)
    step = min(0.25, 2.0 * half / _COLUMNS)
    x_mm = np.linspace(-half, half, int(np.ceil(2.0 * half / step)) + 1)
    y_mm = np.linspace(-width_mm / 2.0, width_mm / 2.0, int(np.ceil(width_mm / step)) + 1)
    z = np.sqrt(radius_mm**2 - x_mm**2) - radius_mm
    return target_from_heights("strip", x_mm, y_mm, np.tile(z, (len(y_mm), 1)), notes)
