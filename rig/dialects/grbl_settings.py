"""The `$$` settings of a Grbl controller that decide where and how fast it moves."""

from dataclasses import dataclass

Axes = tuple[float, float, float]
"""A value for each of x, y, z."""


@dataclass(frozen=True, kw_only=True)
class GrblSettings:
    """Settings of a controller in the units of the rig; homing is towards +x, +y, +z, where machine positions are 0."""

    steps_per_mm: Axes
    max_speed_mm_s: Axes
    acceleration_mm_s2: Axes
    travel_mm: Axes
    """Machine positions go from minus this to 0 [mm]."""
    junction_deviation_mm: float = 0.01
    homing_feed_mm_s: float = 1.0
    homing_seek_mm_s: float = 20.0
    homing_pull_off_mm: float = 1.0

    @property
    def step_mm(self) -> Axes:
        """Smallest move of each axis [mm]."""
        x, y, z = self.steps_per_mm
        return (1 / x, 1 / y, 1 / z)

    def numbers(self) -> dict[int, float]:
        """Return the settings as the controller numbers them: speeds in mm/min, all reports asked for, limits on."""
        homing = {24: self.homing_feed_mm_s * 60, 25: self.homing_seek_mm_s * 60, 27: self.homing_pull_off_mm}
        per_axis = {
            100: self.steps_per_mm,
            110: tuple(60 * speed for speed in self.max_speed_mm_s),
            120: self.acceleration_mm_s2,
            130: self.travel_mm,
        }
        # 10: machine positions and buffers in reports; 13: mm; 20, 21, 22: soft and hard limits, homing; 32: no laser
        switches = {10: 3, 11: self.junction_deviation_mm, 13: 0, 20: 1, 21: 1, 22: 1, 23: 0, 32: 0}
        axes = {first + axis: value for first, values in per_axis.items() for axis, value in enumerate(values)}
        return {**switches, **homing, **axes}
