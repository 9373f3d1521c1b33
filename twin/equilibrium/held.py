"""Solves with a shell's Hessian while some degrees of freedom are held."""

import numpy as np

from planner.errors import SolverError
from twin.equilibrium.linear import PardisoSolver, SuperLuSolver, sparse_solver
from twin.shell.topology import Pattern


class HeldSystem:
    """The Hessian with rows and columns of held degrees of freedom replaced by those of the identity."""

    def __init__(self, pattern: Pattern, pins: np.ndarray, solver: PardisoSolver | SuperLuSolver | None = None) -> None:
        """Prepare the masks.

        Args:
            pattern: layout of the Hessian's upper triangle.
            pins: held degrees of freedom, 3 vertex + axis.
            solver: solver of the same pattern to share; a factorisation lasts until the next one by any sharer.
        """
        self.pins = pins
        self.free = np.ones(len(pattern.diagonal_place), dtype=bool)
        self.free[pins] = False
        rows = np.repeat(np.arange(len(pattern.indptr) - 1), np.diff(pattern.indptr))
        self._held = np.flatnonzero(~self.free[rows] | ~self.free[pattern.indices])
        self._diagonal = pattern.diagonal_place
        self.solver = solver or sparse_solver(pattern.indptr, pattern.indices)
        self.factorizations = 0

    def factorize(self, values: np.ndarray) -> bool:
        """Factorise; False if the matrix is not positive definite. Overwrites the held entries of `values`."""
        values[self._held] = 0.0
        values[self._diagonal[self.pins]] = 1.0
        self.factorizations += 1
        return self.solver.factorize(values)

    def factorize_shifted(self, values: np.ndarray) -> None:
        """Factorise with the first multiple of the identity added, of a rising series, that makes it definite.

        Raises:
            SolverError: if a value is not finite.
        """
        if not np.isfinite(values).all():
            raise SolverError(
                "equilibrium: the film's stiffness is not finite; its mesh or its layers hold bad values."
            )
        shift = 1e-8 * float(np.abs(values[self._diagonal]).mean())
        while True:
            shifted = values.copy()
            shifted[self._diagonal] += shift
            if self.factorize(shifted):
                return
            shift *= 4.0

    def solve(self, force: np.ndarray) -> np.ndarray:
        """Return the displacements under forces by the last factorisation: [3 n] -> [n, 3], [k, 3 n] -> [k, n, 3].

        Many at once take little longer than one.
        """
        return self.solver.solve(force.T).T.reshape(*force.shape[:-1], -1, 3)

    def softest_mode(self, values: np.ndarray) -> np.ndarray:
        """Return the mode of the lowest eigenvalue, shape [n, 3], its longest vector of length 1."""
        self.factorize_shifted(values)
        # inverse iteration; the start only has to contain the mode, so its seed is no setting
        mode = np.random.default_rng(0).normal(size=len(self.free))
        for _ in range(8):
            mode[self.pins] = 0.0
            mode = self.solver.solve(mode / np.linalg.norm(mode))
        mode = mode.reshape(-1, 3)
        return mode / np.sqrt((mode**2).sum(axis=1).max())

    def lowest_stiffness(self, vertex_area_mm2: np.ndarray) -> float:
        """Return the lowest eigenvalue, per area of the film, of the positive definite Hessian factorised last.

        The smallest of v.Hv / sum(A |v|^2) over all displacements v of the free vertices: the stiffness that the film
        opposes to its softest disturbance, per area. By inverse iteration.

        Args:
            vertex_area_mm2: area of each vertex [mm^2], shape [n].
        """
        area = np.repeat(vertex_area_mm2, 3)
        mode = np.random.default_rng(0).normal(size=len(self.free))
        lowest = np.inf
        for _ in range(30):
            mode[self.pins] = 0.0
            mode /= np.sqrt(float(area @ mode**2))
            response = self.solver.solve(area * mode)
            previous, lowest = lowest, 1.0 / float(area @ (mode * response))
            mode = response
            if abs(previous - lowest) < 1e-4 * lowest:
                break
        return lowest
