"""What the process makes of an intended alignment, as a linear map."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp


@dataclass(frozen=True, kw_only=True, eq=False)
class Distortion:
    """Strength, direction and place of each layer, off by a little."""

    strength: np.ndarray
    """Factor on the contraction of each layer, shape [layers]."""
    turn_rad: np.ndarray
    """Turn of the directors of each layer [rad], shape [layers]."""
    shift: tuple[sp.csr_matrix, ...]
    """For each layer, the map from the triangles' alignment to that of the layer moved as a whole, shape [m, m]."""

    def push(self, q: np.ndarray) -> np.ndarray:
        """Return what becomes of alignment vectors, shape [layers, m, 2]."""
        return np.stack(
            [shift @ own @ matrix.T for shift, own, matrix in zip(self.shift, q, self._matrices(), strict=True)]
        )

    def pull(self, by_q: np.ndarray) -> np.ndarray:
        """Return the gradient by the intended vectors from that by what became of them."""
        return np.stack(
            [shift.T @ own @ matrix for shift, own, matrix in zip(self.shift, by_q, self._matrices(), strict=True)]
        )

    def _matrices(self) -> np.ndarray:
        """Strength times the rotation of (cos 2 theta, sin 2 theta), shape [layers, 2, 2]."""
        cos, sin = np.cos(2.0 * self.turn_rad), np.sin(2.0 * self.turn_rad)
        turns = np.moveaxis(np.array([[cos, -sin], [sin, cos]]), -1, 0)
        return self.strength[:, None, None] * turns
