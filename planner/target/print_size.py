"""The size of the print: scale to a box, or refuse what cannot be millimetres."""

from dataclasses import replace

import numpy as np

from planner.errors import InputError
from planner.target.target import Target

SMALLEST_MM = 2.0
"""Smallest width and height accepted without an explicit size: the neighbours of Eq. 1 lie 2 mm apart [mm]."""
LARGEST_MM = 300.0
"""Largest width and height accepted without an explicit size: the travel of a desktop stage [mm]."""

Size = tuple[float, float]
"""Width (x) and height (y) seen from above [mm]."""


def print_scale(extent_mm: Size, size_mm: Size | None, *, name: str) -> float:
    """Find the factor that brings an extent seen from above to its print size.

    Args:
        extent_mm: Width and height as the file gives them [mm].
        size_mm: Box to fill without distortion [mm], or None to take the file at its word.
        name: Named in messages.

    Raises:
        InputError: The extent is nothing like a print and no size is given, or the size itself is not possible.
    """
    width, height = extent_mm
    if not (width > 0 and height > 0):
        raise InputError(
            f"{name}: seen from above the surface is {width:.4g} x {height:.4g} mm, a line or a point; "
            "check the up direction (--up)."
        )
    if size_mm is None:
        if min(width, height) < SMALLEST_MM or max(width, height) > LARGEST_MM:
            raise InputError(
                f"{name}: seen from above the surface is {width:.4g} x {height:.4g} mm, if its unit is the "
                f"millimetre; allowed are {SMALLEST_MM:g} to {LARGEST_MM:g} mm: "
                "give the size of the print, for example --size-mm 40x60."
            )
        return 1.0
    if not all(SMALLEST_MM <= side <= LARGEST_MM for side in size_mm):
        raise InputError(
            f"size: {size_mm[0]:g} x {size_mm[1]:g} mm asked for; each side must be between {SMALLEST_MM:g} and "
            f"{LARGEST_MM:g} mm, for example --size-mm 40x60."
        )
    return min(size_mm[0] / width, size_mm[1] / height)


def fit_outline(target: Target, size_mm: Size) -> Target:
    """Scale a target so that its outline fills the box; all three axes alike."""
    width, height = target.size_mm
    return scale_target(target, min(size_mm[0] / width, size_mm[1] / height))


def scale_target(target: Target, factor: float) -> Target:
    """Scale all three axes of a target by one factor."""
    return replace(
        target,
        x_mm=target.x_mm * factor,
        y_mm=target.y_mm * factor,
        z_mm=target.z_mm * factor,
        outline_mm=target.outline_mm * factor,
    )


def scale_note(factor: float) -> tuple[str, ...]:
    """Say by how much the source was scaled; nothing where it was not."""
    return () if np.isclose(factor, 1.0, rtol=1e-3) else (f"All three axes were scaled by {factor:.4g}.",)
