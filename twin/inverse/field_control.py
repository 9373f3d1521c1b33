"""The alignment of a film as design variables: smooth fields, one vector a vertex."""

from typing import Literal

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

TINY = 1e-9

Stack = Literal["all", "pairs"]


class FieldControl:
    """Design variables u, shape [fields, n, 2]: q at a vertex is u, its length saturating at the largest contraction.

    A triangle's q is the mean of its vertices'. The penalty is `smoothness` / 2 sum over edges |q_i - q_j|^2, which is
    a Dirichlet energy whatever the mesh is.
    """

    def __init__(
        self,
        triangles: np.ndarray,
        vertex_count: int,
        *,
        layers: int,
        stack: Stack,
        largest: float,
        smoothness: float,
        damping: float,
    ) -> None:
        """Prepare.

        Args:
            triangles: vertex indices of the flat film's mesh, shape [m, 3].
            vertex_count: number of vertices n.
            layers: number of layers.
            stack: whether `all` layers have fields of their own, or the lower and the upper half one each (`pairs`).
            largest: largest contraction.
            smoothness: weight of the penalty.
            damping: unit of the steps' damping.
        """
        m = len(triangles)
        self.field_of_layer = np.arange(layers) if stack == "all" else 2 * np.arange(layers) // layers
        self.largest, self.smoothness, self.damping = largest, smoothness, damping
        self._mean = sp.csr_matrix(
            (np.full(3 * m, 1.0 / 3.0), (np.repeat(np.arange(m), 3), triangles.ravel())), shape=(m, vertex_count)
        )
        self._mean_back = self._mean.T.tocsr()
        self._laplacian = dirichlet(triangles, vertex_count)
        self._precondition = splu((smoothness * self._laplacian + damping * sp.identity(vertex_count)).tocsc())

    @property
    def fields(self) -> int:
        """Number of independent fields."""
        return int(self.field_of_layer[-1]) + 1

    def vertex_q(self, u: np.ndarray) -> np.ndarray:
        """Return the alignment vectors of each layer at the vertices, shape [layers, n, 2]."""
        return self._saturated(u)[self.field_of_layer]

    def q(self, u: np.ndarray) -> np.ndarray:
        """Return the alignment vectors of the triangles, shape [layers, m, 2]."""
        return self._spread(self._saturated(u))

    def push(self, u: np.ndarray, du: np.ndarray) -> np.ndarray:
        """Return the change of the triangles' q for a change of u."""
        return self._spread(self._chain(u, du))

    def pull(self, u: np.ndarray, by_q: np.ndarray) -> np.ndarray:
        """Return the gradient by u from that by the triangles' q."""
        by_vertex = np.zeros_like(u)
        for field, part in zip(self.field_of_layer, by_q, strict=True):
            by_vertex[field] += self._mean_back @ part
        return self._chain(u, by_vertex)

    def penalty(self, u: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the penalty and its gradient by u."""
        q = self._saturated(u)
        slope = self._rough(q)
        return 0.5 * float((q * slope).sum()), self._chain(u, slope)

    def penalty_curve(self, u: np.ndarray, du: np.ndarray) -> np.ndarray:
        """Return the Gauss-Newton curvature of the penalty times du."""
        return self._chain(u, self._rough(self._chain(u, du)))

    def precondition(self, gradient: np.ndarray) -> np.ndarray:
        """Return an approximate inverse of penalty and damping, times a gradient."""
        return np.stack([self._precondition.solve(part) for part in gradient])

    def _rough(self, q: np.ndarray) -> np.ndarray:
        return self.smoothness * np.stack([self._laplacian @ part for part in q])

    def _spread(self, q: np.ndarray) -> np.ndarray:
        return np.stack([self._mean @ part for part in q])[self.field_of_layer]

    def _saturated(self, u: np.ndarray) -> np.ndarray:
        return u * self._saturation(u)[0]

    def _saturation(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return |q| / |u|, d|q| / d|u| and the unit vector of u."""
        length = np.linalg.norm(u, axis=-1, keepdims=True)
        safe = np.maximum(length, TINY)
        ratio = np.where(length > TINY, self.largest * np.tanh(length / self.largest) / safe, 1.0)
        return ratio, 1.0 / np.cosh(np.minimum(length / self.largest, 300.0)) ** 2, u / safe

    def _chain(self, u: np.ndarray, change: np.ndarray) -> np.ndarray:
        """Apply the symmetric derivative of q at the vertices with respect to u."""
        ratio, slope, unit = self._saturation(u)
        radial = (change * unit).sum(axis=-1, keepdims=True)
        return ratio * change + (slope - ratio) * radial * unit


def dirichlet(triangles: np.ndarray, vertex_count: int) -> sp.csc_matrix:
    """Return the graph Laplacian of a mesh's edges, shape [n, n]."""
    ends = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return chain_laplacian(np.unique(ends, axis=0), vertex_count)


def chain_laplacian(pairs: np.ndarray, count: int) -> sp.csc_matrix:
    """Return the matrix of sum (x_i - x_j)^2 over pairs, shape [k, 2] -> [count, count]."""
    difference = sp.csr_matrix(
        (np.tile([1.0, -1.0], len(pairs)), (np.repeat(np.arange(len(pairs)), 2), pairs.ravel())),
        shape=(len(pairs), count),
    )
    return (difference.T @ difference).tocsc()
