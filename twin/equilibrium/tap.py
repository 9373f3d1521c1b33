"""Tap a film that only its weight holds down, and see whether it comes back."""

import logging
from dataclasses import dataclass

import numpy as np

from planner.errors import SolverError
from twin.equilibrium.held import HeldSystem
from twin.equilibrium.newton import Equilibrium, Newton
from twin.equilibrium.pins import rigid_pins

logger = logging.getLogger(__name__)

LEAST_GAIN = 1e-6
"""Relative energy that another state must gain to count as another one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Tapped:
    """Where a tap led to."""

    equilibrium: Equilibrium
    moved_mm: float
    """How far a vertex is from where it was before; 0 where the film came back."""


class Tap:
    """A push along the softest mode of the film without weight and plate, both ways."""

    def __init__(self, newton: Newton, amplitude_mm: float, force_scale: float, rng: np.random.Generator) -> None:
        self._newton, self._force_scale, self._amplitude_mm = newton, force_scale, amplitude_mm
        self._first_sign = rng.choice((-1.0, 1.0))
        shell = newton.shell
        pins = rigid_pins(shell.film.flat_mm, on_plate=False)
        self._weightless = HeldSystem(shell.pattern, pins, newton.system.solver)

    def __call__(self, held: Equilibrium, tolerance: float) -> Tapped:
        """Return the equilibrium of less energy that a tap leads to, or `held` itself."""
        values = self._newton.shell.elastic_hessian(held.vertices_mm)
        if self._weightless.factorize(values):
            return Tapped(equilibrium=held, moved_mm=0.0)
        mode = self._weightless.softest_mode(values)
        for sign in (self._first_sign, -self._first_sign):
            tapped = held.vertices_mm + sign * self._amplitude_mm * mode
            tapped[:, 2] -= min(0.0, float(tapped[:, 2].min()))
            try:
                found = self._newton.solve(tapped, force_scale=self._force_scale, tolerance=tolerance)
            except SolverError as error:
                logger.info("tap: %s", error)
                continue
            if found.energy < held.energy - LEAST_GAIN * abs(held.energy):
                moved = float(np.linalg.norm(found.vertices_mm - held.vertices_mm, axis=1).max())
                logger.info("a tap moved the film by %.2f mm", moved)
                return Tapped(equilibrium=found, moved_mm=moved)
        return Tapped(equilibrium=held, moved_mm=0.0)
