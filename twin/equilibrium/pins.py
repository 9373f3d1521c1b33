"""Which degrees of freedom to hold so that a film cannot drift, without loading it."""

import numpy as np


def rigid_pins(flat_mm: np.ndarray, *, on_plate: bool) -> np.ndarray:
    """Return the degrees of freedom (3 vertex + axis) to hold, as few as there are free rigid motions.

    A free film holds three vertices by the 3-2-1 rule; on the plate, height and tilt are decided by weight and
    contact, so only the two shifts and the turn in the plane are held. Loads that balance leave no reaction.

    Args:
        flat_mm: flat vertices [mm], shape [n, 2].
        on_plate: whether gravity and the plate hold height and tilt.
    """
    centred = flat_mm - flat_mm.mean(axis=0)
    reach = 0.5 * np.abs(centred).max(axis=0)
    middle = int(np.argmin((centred**2).sum(axis=1)))
    right = int(np.argmin(((centred - (reach[0], 0.0)) ** 2).sum(axis=1)))
    above = int(np.argmin(((centred - (0.0, reach[1])) ** 2).sum(axis=1)))
    pins = [3 * middle, 3 * middle + 1, 3 * right + 1]
    if not on_plate:
        pins += [3 * middle + 2, 3 * right + 2, 3 * above + 2]
    return np.array(sorted(pins))
