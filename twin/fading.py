"""Alignment fades while an uncured layer waits for its cure."""

import numpy as np
from numpy.typing import ArrayLike

from planner.program import Machine, Program, layer_times

FADING_TAU_H = 2.5
"""The paper saw alignment last 2 to 3 hours (section 3): then a third of it is left, after another hour a seventh."""
SECONDS_PER_HOUR = 3600.0


def remaining_alignment(waiting_s: ArrayLike, *, tau_h: float = FADING_TAU_H) -> np.ndarray:
    """Return the share Q of the contraction that is left when the layer is cured, shape of `waiting_s`.

        Q(t) = exp(-(t / tau)^2)

    Fading starts slowly: an hour's wait costs 15 %. The form is an assumption; the paper gives the duration only.

    Args:
        waiting_s: time from the scratch to the start of the cure [s].
        tau_h: time after which 1/e is left [h].
    """
    return np.exp(-((np.asarray(waiting_s, dtype=float) / (SECONDS_PER_HOUR * tau_h)) ** 2))


def pass_strengths(program: Program, machine: Machine, *, tau_h: float = FADING_TAU_H) -> tuple[np.ndarray, ...]:
    """Return for each layer, bottom first, the share of contraction left of each of its passes, shape [passes].

    Each pass counts from its middle, at the machine's speeds; other layers are cured by then and do not fade.
    """
    return tuple(remaining_alignment(time.pass_to_cure_s, tau_h=tau_h) for time in layer_times(program, machine))
