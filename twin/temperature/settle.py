"""Find shape and temperature together, where each follows from the other."""

import logging
from collections.abc import Callable

import numpy as np
from scipy.optimize import NoConvergence, anderson

from planner.errors import SolverError

logger = logging.getLogger(__name__)

TOLERANCE = 1e-4
"""Largest difference of a triangle's activation between two rounds at which both count as found."""
FIRST_SHARE = 0.5
"""Share of the first change that is taken: all of it overshoots where the transition is steep."""
MEMORY = 5
ROUNDS = 40


def settle_activation(follow: Callable[[np.ndarray], np.ndarray], start: np.ndarray) -> np.ndarray:
    """Return the activation that the film has in the very shape that this activation gives it, shape [m].

    Lifting cools and cooling lowers, so that taking turns swings about the answer, and away from it where lifted film
    is near its transition. Anderson's mixing of the last rounds (Anderson 1965, doi 10.1145/321296.321305) settles
    in 3 to 8 rounds on ramps of a dozen temperatures where taking turns needs up to 60, or fails.

    Args:
        follow: finds the equilibrium under an activation [m] and returns the activation that belongs to its shape,
            as `field_activation` gives it; it starts from the shape that it found last.
        start: first activation, in [0, 1], shape [m].

    Raises:
        SolverError: if the two do not come together in 40 rounds.
    """
    rounds = 0

    def change(activation: np.ndarray) -> np.ndarray:
        nonlocal rounds
        rounds += 1
        inside = np.clip(activation, 0.0, 1.0)
        return follow(inside) - inside

    try:
        found = anderson(
            change,
            start,
            alpha=FIRST_SHARE,
            M=MEMORY,
            maxiter=ROUNDS,
            f_tol=TOLERANCE,
            x_rtol=1e300,  # no condition; the default, infinity, divides infinity by itself in the first round
            line_search=None,
        )
    except NoConvergence as error:
        raise SolverError(
            f"temperature: shape and temperature do not settle in {rounds} rounds; use smaller temperature steps, or "
            "the uniform temperature field."
        ) from error
    logger.info("temperature and shape settled in %d rounds", rounds)
    return np.clip(np.asarray(found), 0.0, 1.0)
