"""The form of a calibration map: a curve that saturates with load and falls with speed, in four numbers.

    contraction e(F, v) = e0 (1 - exp(-(F / F0)^q)) (v / v0)^-p,    log R = log(radius of the strip at e)

It is the form of the placeholder, with its numbers free, and with q for how suddenly alignment saturates. All four
are positive by construction, so the map is monotone whatever the strips say. What the form cannot follow is left to
the deviation in `map_posterior`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.calibration.wide_strip import CONTRACTION_MAX, radius_for_contraction

PRIOR_MEAN = np.log((0.25, 2.0, 0.45, 1.0))
"""Logarithms of e0, a strong contraction, of F0 [g], of the speed's exponent p and of the load's q."""
PRIOR_DEVIATION = np.array((1.5, 1.0, 1.0, 0.5))
"""A factor of 4.5, 2.7, 2.7 and 1.6: wide, so that they matter only for what the strips do not tell."""


@dataclass(frozen=True, kw_only=True)
class MapForm:
    """The form for one kind of strip."""

    layer_thickness_mm: Sequence[float]
    """Bottom first [mm]."""
    aligned: Sequence[int]
    width_mm: float
    """Of the strips [mm]."""
    speed_mm_s: float
    """Reference speed v0 [mm/s]."""

    def log_radius(self, parameters: np.ndarray, load_g: np.ndarray, speed_mm_s: np.ndarray) -> np.ndarray:
        """Return log(radius / mm) for parameters [4] and settings of any one shape."""
        amplitude, scale, exponent, suddenness = np.exp(parameters)
        strength = -np.expm1(-((load_g / scale) ** suddenness)) * (speed_mm_s / self.speed_mm_s) ** -exponent
        e = np.minimum(amplitude * strength, CONTRACTION_MAX)
        return np.log(radius_for_contraction(np.maximum(e, 1e-6), self.layer_thickness_mm, self.aligned, self.width_mm))

    def slope(self, parameters: np.ndarray, load_g: np.ndarray, speed_mm_s: np.ndarray) -> np.ndarray:
        """Return the derivatives of `log_radius` by the parameters, shape [n, 4]."""
        step = 1e-4
        return np.stack(
            [
                (
                    self.log_radius(parameters + step * unit, load_g, speed_mm_s)
                    - self.log_radius(parameters - step * unit, load_g, speed_mm_s)
                )
                / (2.0 * step)
                for unit in np.eye(len(PRIOR_MEAN))
            ],
            axis=-1,
        )
