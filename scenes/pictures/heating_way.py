"""The way of a sheet through the shapes that were calculated while it was heated, as one smooth motion."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

TEMPERATURE_SHARE = 0.5
"""How far time follows the plate's temperature, and for the rest the way of the sheet: it does little up to 90 C and
nearly all within ten degrees, where a film in temperature alone would only jump."""
LEAST = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False)
class HeatingWay:
    """Shapes and temperatures between those that were calculated, along curves that overshoot none (PCHIP)."""

    shapes: PchipInterpolator
    temperatures: PchipInterpolator
    range_c: tuple[float, float]
    """Lowest and highest temperature of the plate [C]."""

    def at(self, time: float) -> tuple[np.ndarray, float]:
        """Return the vertices [mm], shape [n, 3], and the plate's temperature [C] at a time from 0, cold, to 1, hot."""
        return self.shapes(time), float(self.temperatures(time))


def heating_way(temperature_c: np.ndarray, vertices_mm: np.ndarray) -> HeatingWay:
    """Join shapes to a way.

    Args:
        temperature_c: temperature of the plate at each shape [C], shape [k].
        vertices_mm: the shapes [mm], shape [k, n, 3].
    """
    place = _places(temperature_c, vertices_mm)
    return HeatingWay(
        shapes=PchipInterpolator(place, vertices_mm, axis=0),
        temperatures=PchipInterpolator(place, temperature_c),
        range_c=(float(temperature_c.min()), float(temperature_c.max())),
    )


def _places(temperature_c: np.ndarray, vertices_mm: np.ndarray) -> np.ndarray:
    """Return when each shape is reached, from 0 to 1, shape [k]."""
    warmer = np.abs(np.diff(temperature_c))
    moved = np.sqrt((np.diff(vertices_mm, axis=0) ** 2).sum(axis=2).mean(axis=1))
    steps = np.full(len(warmer), LEAST)
    for way, share in ((warmer, TEMPERATURE_SHARE), (moved, 1.0 - TEMPERATURE_SHARE)):
        steps += share * way / max(float(way.sum()), LEAST)
    return np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
