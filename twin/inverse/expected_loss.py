"""What noise of the process is expected to cost a design, with its exact gradient.

A film answers nearly every error in the same few soft ways. With these displacements v_k, orthonormal in the quadratic
form C of what displacements cost, and errors of covariance Cov(q) in the alignment, noise costs on average

    L = sum_k s_k^t Cov(q) s_k / 2,     s_k = B^t a_k,     a_k = -H^-1 C v_k,

one solve for each way, however many errors there are. The gradient needs no derivative of H and B but along two
directions: with the change n_k = Cov(q) s_k and its move J_k = -H^-1 B n_k,

    dL = sum_k ( d[ a_k^t (H J_k + B n_k) ] with a_k, J_k and n_k held, + s_k^t dCov(q) s_k / 2 ),

and a^t (H J + B n) is the mixed second derivative of the energy along (a, 0) and (J, n), so that its own derivatives
are central differences of dE/dx and dE/dq: four evaluations of forces for each way.
"""

import logging
from typing import Protocol

import numpy as np

from twin.inverse.noise import ProcessErrors
from twin.inverse.world import World

logger = logging.getLogger(__name__)

NOISE_WEIGHT = 2.0
"""Weight of the expected loss beside what the film as intended costs: of films at the 10th percentile rather than of
the mean."""
NOISE_HEIGHTS, NOISE_OUTLINE = 0.15, 0.5
"""Factors on the mismatch's rms^2 and outline^2/2 in C: so weighed, the loss is nearest to what noisy films really lose
in similarity."""
WAYS = 12
"""Displacements that are followed: on faces these have 95 % of what noise costs."""
STEP_MM, STEP_Q = 1e-5, 1e-6
"""Largest change of a vertex and of an alignment vector in the differences: a thousandth of the layer above the plate
in which contact sets in, since the third derivative jumps where a vertex enters it. Rounding is 2e-5 of the result."""


class Cost(Protocol):
    """A quadratic form of displacements."""

    def curve(self, displacement_mm: np.ndarray, /) -> np.ndarray:
        """Return the curvature times a displacement, both [n, 3]."""
        ...


class ExpectedLoss:
    """L at one design after the other, in the soft ways of the first."""

    def __init__(self, world: World, errors: ProcessErrors, cost: Cost, q: np.ndarray, *, ways: int = WAYS) -> None:
        """Find the soft ways of a film.

        Args:
            world: the film, linearised at a design; so it must be at each one before `at`, and still in `gradient`.
            errors: of the process, on its mesh.
            cost: C, what a displacement of the vertices costs.
            q: the alignment of that design, shape [layers, m, 2].
            ways: how many are followed at most.
        """
        self._world, self._errors = world, errors
        changes = errors.examples(q)
        moves = world.push(np.stack(changes))
        costs = [cost.curve(move) for move in moves]
        gram = np.array([[float((move * c).sum()) for c in costs] for move in moves])
        values, mixes = np.linalg.eigh(gram)
        kept = np.flatnonzero(values > 1e-9 * values[-1])[::-1][:ways]
        self.worst = np.tensordot(mixes[:, -1], changes, axes=1)
        """What one standard deviation of the mix of errors that costs most changes, shape [layers, m, 2]."""
        self._costs = np.stack([np.tensordot(mixes[:, k], costs, axes=1) / np.sqrt(values[k]) for k in kept])
        logger.info("soft ways: %.3f of the expected loss %.4f", values[kept].sum() / values.sum(), values.sum() / 2.0)
        self.value = 0.0

    def at(self, q: np.ndarray, vertices_mm: np.ndarray) -> None:
        """Work out the loss of a design: alignment [layers, m, 2] and equilibrium [mm], shape [n, 3]."""
        self._q, self._vertices = q, vertices_mm
        found = [self._errors.variance(q, s) for s in self._world.pull(self._costs)]
        self.value = 0.5 * sum(value for value, _, _ in found)
        self._spread = np.stack([spread for _, spread, _ in found])
        self._by_q = np.sum([by_q for _, _, by_q in found], axis=0)

    def gradient(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the gradient by q with the vertices held, [layers, m, 2], and that by the vertices, [n, 3].

        The whole gradient by q is the first plus what `World.pull` makes of the second.
        """
        by_q, by_vertices = self._by_q.copy(), np.zeros_like(self._vertices)
        adjoints, moves = self._world.adjoint(self._costs), self._world.push(self._spread)
        for spread, adjoint, move in zip(self._spread, adjoints, moves, strict=True):
            k = 1.0 / max(np.abs(move).max() / STEP_MM, np.abs(spread).max() / STEP_Q, 1e-300)
            h = STEP_MM / max(np.abs(adjoint).max(), 1e-300)
            for one in (1.0, -1.0):
                there = self._vertices + one * k * move
                plus, minus = self._world.forces(self._q + one * k * spread, (there + h * adjoint, there - h * adjoint))
                weight = one / (4.0 * h * k)
                by_vertices += weight * (plus[0] - minus[0])
                by_q += weight * (plus[1] - minus[1])
        return by_q, by_vertices
