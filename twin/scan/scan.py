"""A scanned surface, from a file or from the virtual scanner."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True, eq=False)
class Scan:
    """What a scanner saw, in its own frame, z towards the scanner or unknown."""

    vertices_mm: np.ndarray
    """Vertices or cloud points [mm], shape [n, 3], float."""
    triangles: np.ndarray | None
    """Vertex indices, shape [m, 3], int; None for a bare point cloud."""
    notes: tuple[str, ...] = ()
    """Sentences that the user should see about how the scan was read."""
