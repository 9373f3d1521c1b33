"""The simulated machine: every virtual device on one clock, and the truth about them."""

import time
from random import Random

from rig.machine_file import RigDescription
from rig.transport import SimulatedTransport, VirtualClock
from rig.virtual.grbl import VirtualGrbl
from rig.virtual.new_era import VirtualPump
from rig.virtual.peripherals import SimulatedEnclosure, SimulatedExtruder, SimulatedHeater, SimulatedLamp


class PacedClock(VirtualClock):
    """Virtual time that passes so many times as fast as the wall's, so that a person can watch or real devices join."""

    def __init__(self, pace: float) -> None:
        super().__init__()
        self._pace = pace
        self._begun_s = time.monotonic()

    def now_s(self) -> float:
        """Return the time since the clock was made [s]."""
        self._now_s = max(self._now_s, (time.monotonic() - self._begun_s) * self._pace)
        return self._now_s

    def sleep(self, duration_s: float) -> None:
        """Let time pass [s]."""
        self.advance_to(self.now_s() + duration_s)

    def advance_to(self, time_s: float) -> None:
        """Wait until it is a time [s]; one that is past changes nothing."""
        time.sleep(max(0.0, (time_s - self.now_s()) / self._pace))
        super().advance_to(time_s)


class VirtualMachine:
    """A machine just switched on. Its public attributes are the truth, open to tests at any time."""

    def __init__(self, rig: RigDescription, clock: VirtualClock) -> None:
        simulated = rig.file.simulated
        self.clock = clock
        self.grbl = VirtualGrbl(rig.controller())
        self.pump = VirtualPump(address=rig.file.pump.address, lag_s=simulated.pump_lag_s)
        self.extruder = SimulatedExtruder(clock)
        self.lamp = SimulatedLamp(clock)
        self.hot_air = SimulatedHeater(clock)
        self.hot_plate = SimulatedHeater(clock)
        self.enclosure = SimulatedEnclosure()
        self._ml_per_g = rig.machine.pump.ml_per_g
        self._friction_g = simulated.post_friction_g
        self._noise_g = simulated.post_noise_g
        self._random = Random(simulated.seed)

    def stage_line(self) -> SimulatedTransport:
        """Return a line to the stage's controller."""
        return SimulatedTransport(self.grbl, self.clock)

    def pump_line(self) -> SimulatedTransport:
        """Return a line to the pump."""
        return SimulatedTransport(self.pump, self.clock)

    def force_g(self) -> float:
        """Return what the lowered post presses with: the water that has arrived, less the guide's friction [g].

        The pump's counters know of neither its lag nor friction, nor noise.
        """
        self.pump.next_event_s(self.clock.now_s())  # brings the water up to the present
        held_g = self.pump.plunger.water_ml / self._ml_per_g - self._friction_g
        return max(0.0, held_g + self._random.gauss(0.0, self._noise_g))
