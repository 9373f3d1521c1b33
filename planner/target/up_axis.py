"""Which axis of a file points up, out of the flat film."""

import numpy as np

from planner.errors import InputError

ROTATIONS = {
    "+z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "-z": ((-1, 0, 0), (0, 1, 0), (0, 0, -1)),
    "+y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    "-y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "+x": ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
    "-x": ((0, -1, 0), (0, 0, 1), (-1, 0, 0)),
}
"""Rows of the rotation that brings each axis up. None mirrors; where z is not up it, or y, stays the upright
direction of the page, as in the usual views of a drawing."""


def turn_up(points: np.ndarray, up: str) -> np.ndarray:
    """Rotate points so that the named axis of the file becomes +z, shape [n, 3] -> [n, 3].

    Raises:
        InputError: The axis is unknown.
    """
    if up not in ROTATIONS:
        raise InputError(f"up: {up!r} is not a direction; allowed are {', '.join(ROTATIONS)}.")
    return points @ np.array(ROTATIONS[up], dtype=float).T
