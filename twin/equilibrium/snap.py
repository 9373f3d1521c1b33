"""Did the film snap between two activations? The way back tells."""

import logging

import numpy as np

from planner.errors import SolverError
from twin.equilibrium.newton import Equilibrium, Newton
from twin.equilibrium.rigid import rigid_distance_mm

logger = logging.getLogger(__name__)

SNAP_MM = 0.01
"""A way back that ends farther from where the way there began is another way."""
SAME_ENERGY = 1e-6
"""Relative difference of energy below which two shapes are one that turned freely, or its mirror image."""
ROUGH = 100.0
"""A film that returns is seen to return long before it is in balance: over the tolerance."""
DEPARTURE = 0.3
"""Distance from the extrapolated shape, over the extrapolated way, from which on a step is worth the way back."""


def departs(before_mm: np.ndarray, predicted_mm: np.ndarray | None, found_mm: np.ndarray) -> bool:
    """Return whether a step led so far from where it was expected to lead that the film may have snapped.

    Args:
        before_mm: shape before the step [mm], shape [n, 3].
        predicted_mm: shape extrapolated from the steps before [mm], shape [n, 3]; None if nothing is expected.
        found_mm: equilibrium found [mm], shape [n, 3].
    """
    expected = before_mm if predicted_mm is None else predicted_mm
    missed = float(np.linalg.norm(found_mm - expected, axis=1).max())
    way = float(np.linalg.norm(expected - before_mm, axis=1).max())
    return missed > max(DEPARTURE * way, SNAP_MM)


def snapped_mm(
    newton: Newton,
    before: Equilibrium,
    after: Equilibrium,
    activation: float,
    *,
    force_scale: float,
    tolerance: float,
) -> float:
    """Return how far from `before` the film ends that goes back from `after` to its activation, 0 if it returns.

    Equilibria on one branch lead to each other in both directions; one that was reached by a jump does not lead back.
    The shell is left as it is at that activation.

    Args:
        newton: solver of the film.
        before: equilibrium before the step.
        after: equilibrium after it.
        activation: the one that `before` belongs to.
        force_scale: as of `Newton.solve`.
        tolerance: as of `Newton.solve`.

    Returns:
        Largest distance of a vertex after the best rigid motion [mm].
    """
    newton.prescribe(activation, after.vertices_mm)
    back, missed = after, np.inf
    for accuracy in (ROUGH * tolerance, tolerance):
        try:
            back = newton.solve(back.vertices_mm, force_scale=force_scale, tolerance=accuracy)
        except SolverError as error:
            logger.info("way back: %s", error)
            return 0.0
        missed = rigid_distance_mm(back.vertices_mm, before.vertices_mm)
        if missed < SNAP_MM:
            return 0.0
    return 0.0 if abs(back.energy - before.energy) < SAME_ENERGY * abs(before.energy) else missed
