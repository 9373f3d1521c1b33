"""The map from the target surface to the flat film."""

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True, kw_only=True, eq=False)
class Flattening:
    """A triangulated surface and where each of its vertices lies on the flat film.

    The film frame has the target's orientation (face upright stays upright) and is placed so that the mean of
    `film_mm - vertices_mm[:, :2]` over the vertices is zero.
    """

    method: str
    """`grid` (the paper's grid-block algorithm) or `arap`."""
    vertices_mm: np.ndarray
    """Vertices on the target surface [mm], shape [n, 3], float."""
    triangles: np.ndarray
    """Vertex indices, counter-clockwise seen from above, shape [m, 3], int."""
    film_mm: np.ndarray
    """The same vertices on the flat film [mm], shape [n, 2], float."""
    notes: tuple[str, ...] = field(default=())
    """Sentences that the user should see about how the surface was laid flat."""
