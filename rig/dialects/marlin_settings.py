"""What a Marlin controller is set to, as far as it decides where and how fast it moves."""

from dataclasses import dataclass

from rig.dialects.grbl_settings import Axes


@dataclass(frozen=True, kw_only=True)
class MarlinSettings:
    """Settings of a three-axis Marlin in the units of the rig."""

    steps_per_mm: Axes
    max_speed_mm_s: Axes
    acceleration_mm_s2: Axes
    travel_mm: Axes
    """Positions go from 0 to this [mm]; homing ends at 0, 0 and the highest z, away from the film."""
    homing_speed_mm_s: float = 5.0
    junction_deviation_mm: float = 0.01

    @property
    def step_mm(self) -> Axes:
        """Smallest move of each axis [mm]."""
        x, y, z = self.steps_per_mm
        return (1 / x, 1 / y, 1 / z)

    @property
    def home_mm(self) -> Axes:
        """Where homing ends [mm]."""
        return (0.0, 0.0, self.travel_mm[2])
