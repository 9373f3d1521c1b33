"""Sparse direct solution of symmetric systems given by their upper triangle."""

import os

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import SuperLU, splu

try:
    from pypardiso import PyPardisoSolver
    from pypardiso.pardiso_wrapper import PyPardisoError

    HAVE_PARDISO = True
except ImportError:  # not published for this platform
    HAVE_PARDISO = False

os.environ.setdefault("MKL_CBWR", "AUTO")
"""Read when MKL is first used: it then sums in the same order each time on one machine."""

POSITIVE_DEFINITE = 2
NOT_POSITIVE_DEFINITE = -4


class PardisoSolver:
    """Cholesky by MKL PARDISO: the symbolic analysis is done once, each factorisation reuses it."""

    def __init__(self, indptr: np.ndarray, indices: np.ndarray) -> None:
        self._count = len(indptr) - 1
        self._matrix = sp.csr_matrix((np.ones(len(indices)), indices, indptr), shape=(self._count, self._count))
        self._solver = _open_pardiso()
        self._analysed = False

    def factorize(self, values: np.ndarray) -> bool:
        """Factorise the matrix with these upper-triangle values; False if it is not positive definite."""
        self._matrix.data = values
        self._solver.set_phase(22 if self._analysed else 12)
        try:
            self._solver._call_pardiso(self._matrix, np.zeros((self._count, 1)))
        except PyPardisoError as error:
            if error.value != NOT_POSITIVE_DEFINITE:
                raise
            self._analysed = True
            return False
        self._analysed = True
        return True

    def solve(self, right_side: np.ndarray) -> np.ndarray:
        """Return the solution for the last factorisation."""
        self._solver.set_phase(33)
        return self._solver._call_pardiso(self._matrix, np.asfortranarray(right_side))

    def close(self) -> None:
        """Release the memory that MKL holds for this matrix."""
        self._solver.free_memory(everything=True)


def _open_pardiso() -> "PyPardisoSolver":
    """Return a new handle of the library."""
    solver = PyPardisoSolver(mtype=POSITIVE_DEFINITE)
    if solver.libmkl is not None:
        # without a fixed number of cores the order of sums, and with it the last digits, would depend on the load
        solver.set_iparm(34, solver.libmkl.MKL_Get_Max_Threads())
        # the wrapper searches the disk for the library each time, half a second, unless it is told
        os.environ.setdefault("PYPARDISO_MKL_RT", solver.libmkl._name)
    return solver


class SuperLuSolver:
    """Symmetric-mode LU by scipy, for platforms without MKL: ten times slower, same results."""

    def __init__(self, indptr: np.ndarray, indices: np.ndarray) -> None:
        self._shape = (len(indptr) - 1, len(indptr) - 1)
        self._indptr, self._indices = indptr, indices
        self._factor: SuperLU | None = None

    def factorize(self, values: np.ndarray) -> bool:
        """Factorise the matrix with these upper-triangle values; False if it is not positive definite."""
        upper = sp.csr_matrix((values, self._indices, self._indptr), shape=self._shape)
        full = (upper + sp.triu(upper, 1).T).tocsc()
        try:
            factor = splu(full, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except RuntimeError:  # exactly singular
            return False
        self._factor = factor
        # with diagonal pivoting L U = L D L^t, so the pivots carry the signs of the eigenvalues
        return bool(np.all(factor.U.diagonal() > 0.0) and np.array_equal(factor.perm_r, factor.perm_c))

    def solve(self, right_side: np.ndarray) -> np.ndarray:
        """Return the solution for the last factorisation."""
        if self._factor is None:
            raise RuntimeError("solve before factorize")
        return self._factor.solve(right_side)

    def close(self) -> None:
        """Release the factor."""
        self._factor = None


def solve_on_one_core() -> None:
    """Let the solvers that the calling thread makes from now on use one core, for threads that work side by side.

    MKL crashes where a factorisation uses another number of cores than its analysis: call it first in a thread.
    """
    library = _open_pardiso().libmkl if HAVE_PARDISO else None
    if library is not None:
        library.MKL_Set_Num_Threads_Local(1)


def sparse_solver(indptr: np.ndarray, indices: np.ndarray) -> PardisoSolver | SuperLuSolver:
    """Return the fastest solver present for the symmetric matrix with this upper-triangle CSR pattern."""
    return PardisoSolver(indptr, indices) if HAVE_PARDISO else SuperLuSolver(indptr, indices)
