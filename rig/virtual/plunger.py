"""The moving part of a virtual syringe pump: its program, its plunger, and the water behind the plunger.

The plunger keeps a constant speed between events and the water follows with a lag, so time is passed exactly, from
event to event, without steps.

Source: NE-1000 user manual, chapter 5 (pumping).
"""

from dataclasses import dataclass
from math import exp, floor, inf, pi
from typing import Final

RATE_ML_MIN: Final = {"MM": 1.0, "UM": 1e-3, "MH": 1 / 60, "UH": 1e-3 / 60}
DIRECTIONS: Final = {"INF": 1, "WDR": -1}
STEP_MM: Final = 0.00021
"""Plunger's step [mm]."""
UL_UP_TO_MM: Final = 14.0
"""Widest syringe whose volumes the pump tells in uL [mm]."""


@dataclass(kw_only=True)
class Phase:
    """One phase of the pumping program; its volume is in the pump's units, and 0 is without end."""

    function: str = "STP"
    rate: float = 1.0
    rate_units: str = "MM"
    volume: float = 0.0
    direction: str = "INF"


class Plunger:
    """Plunger under a pumping program. Its public attributes are the truth, and open to tests at any time."""

    def __init__(self, *, diameter_mm: float, lag_s: float) -> None:
        self.lag_s = lag_s
        self.phases = {1: Phase(function="RAT")}
        self.running = False
        self.paused = False
        self.runs = 0
        """How often it was started."""
        self.moved_ml = 0.0
        """Volume pushed less volume drawn since the beginning [mL]."""
        self.travelled_ml = 0.0
        """Volume moved either way since the beginning [mL]."""
        self.water_ml = 0.0
        """What of it has reached the chamber [mL]."""
        self._now_s = 0.0
        self._phase = 1
        self._phase_ml = 0.0
        self.set_diameter(diameter_mm)

    @property
    def area_mm2(self) -> float:
        """Cross section of the syringe [mm2]."""
        return pi / 4 * self.diameter_mm**2

    @property
    def step_ml(self) -> float:
        """Volume of one step [mL]."""
        return self.area_mm2 * STEP_MM * 1e-3

    @property
    def unit_ml(self) -> float:
        """Size of the unit of volume [mL]."""
        return 1e-3 if self.units == "UL" else 1.0

    @property
    def direction(self) -> str:
        """Direction of the phase that runs, `INF` or `WDR`."""
        return self.phases[self._phase].direction

    def set_diameter(self, diameter_mm: float) -> None:
        """Put in another syringe [mm], by which the units follow and the counters start anew."""
        self.diameter_mm = diameter_mm
        self.units = "UL" if diameter_mm <= UL_UP_TO_MM else "ML"
        self.clear_counters()

    def clear_counters(self) -> None:
        """Let both counters start anew."""
        self._counted_ml = dict.fromkeys(DIRECTIONS, 0.0)

    def clear_counter(self, direction: str) -> None:
        """Let one counter start anew."""
        self._counted_ml[direction] = 0.0

    def counted(self, direction: str) -> float:
        """Return a counter in whole steps, in the pump's units."""
        return floor(self._counted_ml[direction] / self.step_ml + 1e-6) * self.step_ml / self.unit_ml

    def run(self) -> None:
        """Start the program, or go on with it after a pause."""
        if not self.paused:
            self._phase, self._phase_ml = 1, 0.0
        self.running, self.paused = True, False
        self.runs += 1

    def pause(self) -> None:
        """Pause the program, or end it if it is paused."""
        self.running, self.paused = False, self.running

    def halt(self) -> None:
        """End the program."""
        self.running = self.paused = False

    def end_s(self) -> float:
        """Return the time at which the phase that runs will be done [s]."""
        phase = self.phases[self._phase]
        # In whole steps, of which it makes at least one.
        target_ml = max(1, round(phase.volume * self.unit_ml / self.step_ml)) * self.step_ml
        return self.travel_s(self.travelled_ml + target_ml - self._phase_ml) if phase.volume else inf

    def travel_s(self, travelled_ml: float) -> float:
        """Return the time at which so much will have been moved either way since the beginning [s]."""
        flow = self._flow_ml_s()
        return self._now_s + max(0.0, travelled_ml - self.travelled_ml) / flow if flow else inf

    def end_phase(self) -> None:
        """Go on to the next phase, or stop if it is the stop."""
        self._phase += 1
        self._phase_ml = 0.0
        if self.phases.setdefault(self._phase, Phase()).function == "STP":
            self._phase = 1
            self.running = False

    def pass_time(self, now_s: float) -> None:
        """Move on to a time [s] before which no event lies."""
        duration_s = now_s - self._now_s
        distance_ml = self._flow_ml_s() * duration_s
        # dw/dt = (p - w) / lag behind a plunger p = p0 + v t, for w at the duration's end.
        trailing_ml = self._flow_ml_s() * DIRECTIONS[self.direction] * self.lag_s
        apart_ml = self.moved_ml - self.water_ml - trailing_ml
        self.moved_ml += DIRECTIONS[self.direction] * distance_ml
        self.water_ml = self.moved_ml - trailing_ml - apart_ml * exp(-duration_s / self.lag_s)
        self.travelled_ml += distance_ml
        self._counted_ml[self.direction] += distance_ml
        self._phase_ml += distance_ml
        self._now_s = now_s

    def _flow_ml_s(self) -> float:
        phase = self.phases[self._phase]
        return phase.rate * RATE_ML_MIN[phase.rate_units] / 60 if self.running else 0.0
