"""The contraction along passes as design variables: paths are fixed, speed and load change."""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from twin.inverse.field_control import chain_laplacian


class PassControl:
    """Design variables p, one a segment: e = middle + reach tanh(p), between bounds that differ from pass to pass.

    The penalty is `smoothness` / 2 sum over neighbouring segments of a pass (e_i - e_j)^2.
    """

    def __init__(
        self,
        painted: Sequence[tuple[sp.csr_matrix, sp.csr_matrix]],
        lengths: Sequence[Sequence[int]],
        low: np.ndarray,
        high: np.ndarray,
        *,
        smoothness: float,
        damping: float = 1e-4,
    ) -> None:
        """Prepare.

        Args:
            painted: for each layer the maps from its segments' contraction to the triangles, see `painted_layer`.
            lengths: for each layer the number of segments of each pass.
            low: least contraction of each segment, all layers joined, shape [segments].
            high: largest contraction, likewise.
            smoothness: weight of the penalty.
            damping: unit of the steps' damping.
        """
        self._painted = painted
        self._painted_back = [(x.T.tocsr(), y.T.tocsr()) for x, y in painted]
        self._splits = np.cumsum([sum(own) for own in lengths])[:-1]
        self._middle, self._reach = 0.5 * (low + high), 0.5 * (high - low)
        self.smoothness, self.damping = smoothness, damping
        ends = np.cumsum([count for own in lengths for count in own])
        joined = np.setdiff1d(np.arange(len(low) - 1), ends - 1)
        self._laplacian = chain_laplacian(np.column_stack((joined, joined + 1)), len(low))
        self._precondition = splu((smoothness * self._laplacian + damping * sp.identity(len(low))).tocsc())

    def start(self, contraction: np.ndarray) -> np.ndarray:
        """Return the variables of contractions, pulled a little inside their bounds."""
        share = (contraction - self._middle) / np.maximum(self._reach, 1e-12)
        return np.arctanh(np.clip(share, -0.98, 0.98))

    def contraction(self, p: np.ndarray) -> np.ndarray:
        """Return the contraction of each segment."""
        return self._middle + self._reach * np.tanh(p)

    def q(self, p: np.ndarray) -> np.ndarray:
        """Return the alignment vectors of the triangles, shape [layers, m, 2]."""
        return self._paint(self.contraction(p))

    def push(self, p: np.ndarray, dp: np.ndarray) -> np.ndarray:
        """Return the change of the triangles' q for a change of p."""
        return self._paint(self._slope(p) * dp)

    def pull(self, p: np.ndarray, by_q: np.ndarray) -> np.ndarray:
        """Return the gradient by p from that by the triangles' q."""
        parts = [x @ own[:, 0] + y @ own[:, 1] for (x, y), own in zip(self._painted_back, by_q, strict=True)]
        return self._slope(p) * np.concatenate(parts)

    def penalty(self, p: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the penalty and its gradient by p."""
        e = self.contraction(p)
        slope = self.smoothness * (self._laplacian @ e)
        return 0.5 * float(e @ slope), self._slope(p) * slope

    def penalty_curve(self, p: np.ndarray, dp: np.ndarray) -> np.ndarray:
        """Return the Gauss-Newton curvature of the penalty times dp."""
        slope = self._slope(p)
        return slope * (self.smoothness * (self._laplacian @ (slope * dp)))

    def precondition(self, gradient: np.ndarray) -> np.ndarray:
        """Return an approximate inverse of penalty and damping, times a gradient."""
        return self._precondition.solve(gradient)

    def _slope(self, p: np.ndarray) -> np.ndarray:
        return self._reach / np.cosh(np.minimum(np.abs(p), 300.0)) ** 2

    def _paint(self, contraction: np.ndarray) -> np.ndarray:
        parts = np.split(contraction, self._splits)
        return np.stack([np.column_stack((x @ own, y @ own)) for (x, y), own in zip(self._painted, parts, strict=True)])
