"""The target surface: a height field over a regular grid, with its outline."""

import hashlib
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np


@dataclass(frozen=True, kw_only=True, eq=False)
class Target:
    """Surface that the hot film should become: z over a regular x-y grid, z up, all lengths in mm.

    The grid is centred: the middle of the bounding box of the outline is x = y = 0, the lowest point z = 0.
    """

    name: str
    """Name shown in reports."""
    x_mm: np.ndarray
    """Grid columns [mm], ascending, evenly spaced, shape [nx], float."""
    y_mm: np.ndarray
    """Grid rows [mm], ascending, evenly spaced, shape [ny], float."""
    z_mm: np.ndarray
    """Heights [mm], NaN outside the outline, shape [ny, nx], float."""
    outline_mm: np.ndarray
    """Smooth closed outline from above [mm], counter-clockwise, first point not repeated, shape [n, 2]."""
    notes: tuple[str, ...] = field(default=())
    """Sentences that the user should see about how the surface was read (scaled, cropped, repaired)."""

    @property
    def size_mm(self) -> tuple[float, float]:
        """Width and height of the outline's bounding box [mm]."""
        low, high = self.bounds_mm
        return float(high[0] - low[0]), float(high[1] - low[1])

    @property
    def bounds_mm(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower left and upper right corner of the outline's bounding box [mm], each shape [2]."""
        return self.outline_mm.min(axis=0), self.outline_mm.max(axis=0)

    @property
    def depth_mm(self) -> float:
        """Height of the highest above the lowest point [mm]."""
        return float(np.nanmax(self.z_mm) - np.nanmin(self.z_mm))

    @property
    def diagonal_mm(self) -> float:
        """Diagonal of the 3-D bounding box [mm], the length that `rms_percent_of_diagonal` refers to."""
        width, height = self.size_mm
        return float(np.sqrt(width**2 + height**2 + self.depth_mm**2))

    @cached_property
    def digest(self) -> str:
        """SHA-256 over grid and heights, rounded to 1 nm so that a round trip through a file keeps it."""
        hasher = hashlib.sha256()
        for array in (self.x_mm, self.y_mm, np.nan_to_num(self.z_mm, nan=-1e6)):
            hasher.update(np.round(np.asarray(array, dtype=float) * 1e6).astype("<i8").tobytes())
        return "sha256:" + hasher.hexdigest()
