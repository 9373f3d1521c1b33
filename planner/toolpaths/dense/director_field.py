"""What dense lines need to know of a field."""

from typing import NamedTuple, Protocol

import numpy as np


class Reading(NamedTuple):
    """A field at points of the plane."""

    q: np.ndarray
    """Alignment vectors, at the nearest point of the film where a point lies beyond its edge, shape [n, 2]."""
    beyond_mm: np.ndarray
    """Distance from the film, 0 on it [mm], shape [n]."""


class DirectorField(Protocol):
    """Alignment vectors q = e (cos 2 theta, sin 2 theta) over the flat film."""

    @property
    def box_mm(self) -> np.ndarray:
        """Lowest and highest corner of the film [mm], shape [2, 2]."""
        ...

    def at(self, xy_mm: np.ndarray) -> Reading:
        """Read the field at points [mm], shape [n, 2]."""
        ...
