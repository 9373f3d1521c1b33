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
    """Turn of the directors of each layer's triangles [rad], shape [layers, m]."""
    shift: tuple[sp.csr_matrix, ...]
    """For each layer, the map from the triangles' alignment to that of the layer moved as a whole, shape [m, m]."""

    def push(self, q: np.ndarray) -> np.ndarray:
        """Return what becomes of alignment vectors, shape [layers, m, 2]."""
        return self._turned(np.stack([shift @ own for shift, own in zip(self.shift, q, strict=True)]), 1.0)

    def pull(self, by_q: np.ndarray) -> np.ndarray:
        """Return the gradient by the intended vectors from that by what became of them."""
        turned_back = self._turned(by_q, -1.0)
        return np.stack([shift.T @ own for shift, own in zip(self.shift, turned_back, strict=True)])

    def _turned(self, q: np.ndarray, sense: float) -> np.ndarray:
        """Return strength times (cos 2 theta, sin 2 theta) turned, forwards or back."""
        cos, sin = np.cos(2.0 * self.turn_rad), sense * np.sin(2.0 * self.turn_rad)
        x, y = q[..., 0], q[..., 1]
        return self.strength[:, None, None] * np.stack((cos * x - sin * y, sin * x + cos * y), axis=-1)
