"""The simulated machine: every virtual device on one clock, and the truth about them."""

from math import dist
from typing import Final

import numpy as np

from rig.dialects.grbl_settings import Axes
from rig.machine_file import RigDescription
from rig.transport import VirtualClock
from rig.virtual.balance import VirtualBalance
from rig.virtual.enclosure import VirtualEnclosure
from rig.virtual.extruder import VirtualExtruder
from rig.virtual.grbl import VirtualGrbl
from rig.virtual.heater import VirtualHeater
from rig.virtual.lamp import VirtualLamp
from rig.virtual.marlin import VirtualMarlin
from rig.virtual.namur import VirtualNamurPlate
from rig.virtual.new_era import VirtualPump
from rig.virtual.post import PostQuality, VirtualPost

AIR_RATE_C_S: Final = 5.0
"""A gun's air warms faster than a plate [C/s]."""
FLOW_ML_MIN: Final = 1.0
"""Flow of an extruder of which the rig's file says nothing [mL/min]."""
PAN_RADIUS_MM: Final = 20.0


class VirtualMachine:
    """A machine just switched on. Its public attributes are the truth, open to tests at any time.

    All of it is there, whatever of it the rig's file lets be simulated.
    """

    def __init__(self, rig: RigDescription, clock: VirtualClock) -> None:
        file, simulated = rig.file, rig.file.simulated
        self.clock = clock
        self.grbl = VirtualGrbl(rig.grbl())
        self.marlin = VirtualMarlin(rig.marlin()) if file.stage.controller == "marlin" else None
        """The stage's controller in the place of `grbl`, if the rig has such a one."""
        self.pump = VirtualPump(address=file.pump.address, lag_s=simulated.pump_lag_s)
        flow_ml_min = FLOW_ML_MIN if file.deposition is None else file.deposition.flow_ml_min
        self.extruder = VirtualExtruder(clock, flow_ml_min=flow_ml_min)
        self.lamp = VirtualLamp(clock, tau_s=file.curing.warm_up_s / 5)
        self.hot_air = VirtualHeater(rate_c_s=AIR_RATE_C_S)
        self.hot_plate = VirtualHeater()
        self.plate = VirtualNamurPlate(self.hot_plate)
        """What speaks for `hot_plate` on a wire."""
        self.enclosure = VirtualEnclosure()
        self._origin = file.stage.origin_mm
        self._balance_line = file.balance_line
        self._arrives = (1 - simulated.pump_leak) / rig.machine.pump.ml_per_g
        quality = PostQuality(
            friction_g=simulated.post_friction_g, lag_s=simulated.post_lag_s, noise_g=simulated.post_noise_g
        )
        self.post = VirtualPost(self._water_g, np.random.default_rng(simulated.seed), quality=quality)
        # a balance weighs the present even if it is told the time of a moment ago
        self.balance = VirtualBalance(lambda _: self.pan_g(), np.random.default_rng([simulated.seed, 1]))

    @property
    def controller(self) -> VirtualGrbl | VirtualMarlin:
        """What the stage hangs on."""
        return self.grbl if self.marlin is None else self.marlin

    def post_mm(self) -> Axes:
        """Return where the post truly is in the film frame [mm]."""
        self.controller.next_event_s(self.clock.now_s())  # brings it up to the present
        x, y, z = (at - zero for at, zero in zip(self.controller.true_mm(), self._origin, strict=True))
        return (x, y, z)

    def force_g(self) -> float:
        """Return what the lowered post presses with; the pump's counters know nothing of leak, lag and friction [g]."""
        return self.post.force_g(self.clock.now_s())

    def pan_g(self) -> float:
        """Return what lies on the balance's pan: the post's force, if it stands there [g]."""
        line = self._balance_line
        if line is None:
            return 0.0
        x, y, z = self.post_mm()
        stands = dist((x, y), line.at_mm) <= PAN_RADIUS_MM and z <= line.pan_mm + 0.01
        return self.post.resting_g(self.clock.now_s()) if stands else 0.0

    def _water_g(self, now_s: float) -> float:
        return self.pump.water_ml(now_s) * self._arrives
