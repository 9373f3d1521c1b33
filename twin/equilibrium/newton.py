"""Newton's method for the equilibrium of a shell at one temperature."""

import logging
from dataclasses import dataclass

import numpy as np

from planner.errors import SolverError
from twin.equilibrium.held import HeldSystem
from twin.shell.shell import Shell

logger = logging.getLogger(__name__)

ARMIJO = 1e-4
ENERGY_ROUNDING = 1e-13
"""Relative energy differences below this are rounding; then the residual decides about a step."""
SADDLE_RESIDUAL = 1e-5
"""Below this relative residual an indefinite Hessian means that Newton is converging to a saddle."""
WAIT = 2
"""Steps with the approximate Hessian after the exact one was found indefinite."""


@dataclass(frozen=True, kw_only=True)
class NewtonOptions:
    """How hard to try."""

    max_iterations: int = 250
    max_step_mm: float = 3.0
    """Longest displacement of a vertex in one step."""
    leave_saddles: bool = True
    """Whether an equilibrium must be stable; if not, a saddle of the energy is returned as it is."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Equilibrium:
    """A converged state."""

    vertices_mm: np.ndarray
    energy: float
    """Energy over mu [mm^3]."""
    relative_residual: float
    """Norm of the residual force over the norm of the element forces of the still-flat film."""
    iterations: int
    stable: bool
    """Whether the exact Hessian with its held degrees of freedom is positive definite."""


class Newton:
    """Minimise a shell's energy; keeps the symbolic factorisation between temperatures."""

    def __init__(self, shell: Shell, pins: np.ndarray, options: NewtonOptions | None = None) -> None:
        self.shell = shell
        self.options = options or NewtonOptions()
        self.system = HeldSystem(shell.pattern, pins)

    def close(self) -> None:
        """Release the factorisation's memory."""
        self.system.solver.close()

    def prescribe(self, activation: float, vertices_mm: np.ndarray) -> None:
        """Prescribe the rest state at an activation, for a film that has this shape [mm], shape [n, 3]."""
        self.shell.set_activation(activation)

    def lowest_stiffness(self, vertices_mm: np.ndarray) -> float:
        """Return the lowest eigenvalue of the Hessian per area of the film over mu [1/mm]; NaN if it is negative."""
        if not self.system.factorize(self.shell.hessian(vertices_mm)[2]):
            return float("nan")
        return self.system.lowest_stiffness(self.shell.film.vertex_area_mm2)

    def solve(self, start_mm: np.ndarray, *, force_scale: float, tolerance: float) -> Equilibrium:
        """Descend from `start_mm` [n, 3] to a stable equilibrium.

        Steps use the exact Hessian where it is positive definite, else its positive semi-definite approximation.
        Where the residual vanishes at a saddle, the film is pushed along the softest mode and goes on.

        Raises:
            SolverError: if the residual is above `tolerance * force_scale` when steps or iterations run out.
        """
        x = np.array(start_mm, dtype=float)
        residual, wait = np.inf, 0
        for iteration in range(self.options.max_iterations + 1):
            exact = wait == 0 or residual <= tolerance
            energy, gradient, values = self.shell.hessian(x, clamp=not exact)
            force = np.where(self.system.free, gradient.ravel(), 0.0)
            residual = float(np.linalg.norm(force)) / force_scale
            definite = self.system.factorize(values)
            settled = residual <= tolerance and exact
            if settled and (definite or not self.options.leave_saddles):
                return Equilibrium(
                    vertices_mm=x,
                    energy=energy,
                    relative_residual=residual,
                    iterations=iteration,
                    stable=definite,
                )
            if iteration == self.options.max_iterations:
                break
            if settled or (exact and not definite and residual <= SADDLE_RESIDUAL and self.options.leave_saddles):
                logger.info("leaving a saddle at residual %.1e", residual)
                x = self._leave_saddle(x, values, energy)
                continue
            wait = WAIT if exact and not definite else max(wait - 1, 0)
            if exact and not definite:
                values = self.shell.hessian(x, clamp=True)[2]
                definite = self.system.factorize(values)
            if not definite:
                self.system.factorize_shifted(values)
            step = -self.system.solve(force)
            moved = self._search(x, step, energy, force)
            if moved is None:
                break
            x = moved
        raise SolverError(
            f"equilibrium: residual {residual:.1e} after {iteration} Newton steps, allowed {tolerance:.1e}; "
            "use smaller temperature steps or a finer mesh."
        )

    def _leave_saddle(self, x: np.ndarray, values: np.ndarray, energy: float) -> np.ndarray:
        """Move along the softest mode as far as the energy falls."""
        mode = self.system.softest_mode(values)
        best, lowest = x, energy
        for sign in (1.0, -1.0):
            length = 1e-3 * self.shell.film.thickness_mm
            while length <= self.options.max_step_mm:
                trial = x + sign * length * mode
                value = self.shell.energy(trial)
                if value < lowest:
                    best, lowest = trial, value
                elif value > energy:
                    break
                length *= 2.0
        if best is x:
            raise SolverError(
                "equilibrium: the film sits at a saddle whose softest mode does not lower the energy; use a finer mesh."
            )
        return best

    def _search(self, x: np.ndarray, step: np.ndarray, energy: float, force: np.ndarray) -> np.ndarray | None:
        """Backtrack along `step` until the energy falls; None if it does not."""
        slope = float(force @ step.ravel())
        longest = float(np.sqrt((step**2).sum(axis=1).max()))
        length = min(1.0, self.options.max_step_mm / longest) if longest > 0 else 1.0
        rounding = ENERGY_ROUNDING * max(abs(energy), self.shell.film.thickness_mm**3)
        for _ in range(30):
            trial = x + length * step
            if -slope * length < rounding:
                gradient = self.shell.gradient(trial)[1].ravel()
                if np.linalg.norm(gradient[self.system.free]) < np.linalg.norm(force):
                    return trial
            elif self.shell.energy(trial) <= energy + ARMIJO * length * slope:
                return trial
            length *= 0.5
        return None
