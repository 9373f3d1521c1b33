"""What a temperature field is, and the activation that follows from it."""

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from twin.film import Film
from twin.material import Material

ROOM_C = 25.0
"""Temperature of the room, at which films are flat [C]."""


class TemperatureField(Protocol):
    """The film's temperature, triangle by triangle, as a function of its shape and of the plate's temperature."""

    kind: ClassVar[str]
    """Name in options and reports."""
    follows_shape: ClassVar[bool]
    """Whether the temperature changes when the film moves, so that shape and temperature must be found together."""

    def temperature_c(self, film: Film, vertices_mm: np.ndarray, plate_c: float) -> np.ndarray:
        """Return the temperature of each triangle [C], shape [m].

        Args:
            film: the film; its flat mesh tells which part of it a triangle is.
            vertices_mm: deformed mid-surface [mm], z = 0 resting on the plate, shape [n, 3].
            plate_c: temperature of the plate, not below the room's [C].
        """
        ...


@dataclass(frozen=True, kw_only=True)
class TemperatureUniform:
    """The whole film has the plate's temperature: a film in an oven, or one that is let lie long under a cover."""

    kind: ClassVar[str] = "uniform"
    follows_shape: ClassVar[bool] = False

    def temperature_c(self, film: Film, vertices_mm: np.ndarray, plate_c: float) -> np.ndarray:
        """Return the plate's temperature for each triangle [C], shape [m]."""
        return np.full(len(film.triangles), float(plate_c))


def field_activation(
    field: TemperatureField, material: Material, film: Film, vertices_mm: np.ndarray, plate_c: float
) -> np.ndarray:
    """Return the fraction of the full contraction that each triangle reaches, shape [m].

    Where `field.follows_shape`, shape and activation determine each other: see `settle_activation`.
    """
    return material.activation(field.temperature_c(film, vertices_mm, plate_c))
