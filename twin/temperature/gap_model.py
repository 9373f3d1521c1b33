"""The gap model: a part of the film that is lifted off an open plate is colder than the plate."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from planner.errors import InputError
from twin.film import Film
from twin.temperature.field import ROOM_C

AIR_W_MK = 0.033
"""Thermal conductivity of air at about 120 C [W/m/K]."""
EMISSIVITY = 0.95
"""Of the elastomer on both faces and of the plate, as of most organic and ceramic surfaces; bare metal has less."""
STEFAN_BOLTZMANN = 5.670374e-8
"""[W/m^2/K^4]."""
KELVIN = 273.15
CONTACT_MM = 0.05
"""Below this height of the mid-surface the film counts as touching in part: its gap grows with the square of the
height, so that temperature is a smooth function of it."""
CONVECTION_ALLOWED = (0.0, 100.0)
ITERATIONS = 50


@dataclass(frozen=True, kw_only=True)
class TemperatureGapModel:
    """Each triangle is as warm as a level film would be at its height above the plate; see `gap_temperature_c`.

    Heat along the film is left out: it evens the temperature out over sqrt(0.2 W/m/K * 0.8 mm / 40 W/m^2/K) = 2 mm.
    So is the film's own resistance, which makes a resting film up to 5 C colder on its top face than underneath.

    Raises:
        InputError: if the convection coefficient is out of range.
    """

    kind: ClassVar[str] = "gap_model"
    follows_shape: ClassVar[bool] = True

    convection_w_m2k: float = 5.0
    """Heat transfer coefficient of the air above the film [W/m^2/K]: 5 in still air to 25 in a draught."""

    def __post_init__(self) -> None:
        low, high = CONVECTION_ALLOWED
        if not low <= self.convection_w_m2k <= high:
            raise InputError(
                f"gap model: convection_w_m2k is {self.convection_w_m2k:g}, allowed are {low:g} to {high:g} W/m2K; "
                "still air has 5, a draught 25."
            )

    def temperature_c(self, film: Film, vertices_mm: np.ndarray, plate_c: float) -> np.ndarray:
        """Return the temperature of each triangle at its mean height [C], shape [m]."""
        height = vertices_mm[:, 2][film.triangles].mean(axis=1)
        touching = np.clip(height, 0.0, CONTACT_MM)
        gap = touching**2 / (2.0 * CONTACT_MM) + np.maximum(height - CONTACT_MM, 0.0)
        return gap_temperature_c(gap, plate_c, convection_w_m2k=self.convection_w_m2k)


def gap_temperature_c(gap_mm: ArrayLike, plate_c: float, *, convection_w_m2k: float) -> np.ndarray:
    """Return the steady temperature of a thin level film above a plate [C], shape of `gap_mm`.

    What conduction through the still air of the gap d and radiation bring is lost by convection and radiation at
    the top, with absolute temperatures T, plate's T_p and room's T_r:

        k_air/d (T_p - T) + e' s (T_p^4 - T^4) = h (T - T_r) + e s (T^4 - T_r^4)

    with k_air = 0.033 W/m/K, emissivity e = 0.95 of all surfaces, e' = 1/(2/e - 1) between two parallel ones. At a
    plate of 150 C in a room of 25 C:

        gap [mm]                      0      0.5    1      2      5      10
        h =  5 W/m^2/K (default)      150    131    121    111    100    94  C
        h = 11                        150    125    113    101    88     82
        h = 25                        150    113    98     84     70     64

    A gap of more than about 10 mm has air that turns over: its conduction is then larger than assumed, at a share
    of the heat that is small already.

    Multiplied by d the equation holds for d = 0 too, where T = T_p. It falls and is concave in T, so that Newton's
    method descends from T_p to the one solution.

    Args:
        gap_mm: height of the gap, >= 0 [mm].
        plate_c: temperature of the plate, not below the room's [C].
        convection_w_m2k: h, heat transfer coefficient at the top [W/m^2/K].
    """
    gap = 1e-3 * np.asarray(gap_mm, dtype=float)
    plate, room = plate_c + KELVIN, ROOM_C + KELVIN
    below, above = STEFAN_BOLTZMANN / (2.0 / EMISSIVITY - 1.0), STEFAN_BOLTZMANN * EMISSIVITY
    film = np.full(gap.shape, plate)
    for _ in range(ITERATIONS):
        lost = convection_w_m2k * (film - room) + above * (film**4 - room**4)
        heating = AIR_W_MK * (plate - film) + gap * (below * (plate**4 - film**4) - lost)
        slope = -AIR_W_MK - gap * (4.0 * (below + above) * film**3 + convection_w_m2k)
        step = heating / slope
        film = film - step
        if np.all(np.abs(step) < 1e-9):
            break
    return film - KELVIN
