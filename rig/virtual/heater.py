"""A virtual heater with its own regulator: a plate or a gun that warms at a limited rate and is measured with a lag.

The body T is heated at most at a rate r, and cools by itself towards the room:

    dT/dt = max(-(T - T_room) / tau_cool, min(r, (T_set - S) / tau)),    dS/dt = (T - S) / lag

with S what the sensor shows. With tau >= 4 lag the regulated pair is overdamped, so that S never passes T_set.
"""

from math import exp, inf
from typing import Final

STEP_S: Final = 0.1
"""Step of the integration [s]; exact within it but for the sensor's lag behind the body."""
RESTING_C: Final = 1e-3


class VirtualHeater:
    """Heater, at first off and as warm as the room. Public attributes are settings and faults, open to tests."""

    def __init__(
        self,
        *,
        room_c: float = 22.0,
        rate_c_s: float = 1.0,
        tau_s: float = 20.0,
        cooling_s: float = 300.0,
        lag_s: float = 3.0,
    ) -> None:
        self.room_c = room_c
        self.rate_c_s = rate_c_s
        """Fastest warming [C/s]; a weak element has less."""
        self.broken_at_s = inf
        """Fault: from this time on the element is dead [s]."""
        self.stuck_at_s = inf
        """Fault: from this time on the element heats whatever is told, its relay being welded [s]."""
        self.sensor_loose_at_s = inf
        """Fault: from this time on the sensor shows the room [s]."""
        self.hottest_c = room_c
        """Highest temperature that the body ever had [C]."""
        self._tau_s = tau_s
        self._cooling_s = cooling_s
        self._lag_s = lag_s
        self._target_c: float | None = None
        self._body_c = self._sensor_c = room_c
        self._now_s = 0.0

    def regulate(self, target_c: float | None, now_s: float) -> None:
        """Warm towards a temperature [C] from a time on [s], or with None be off."""
        self._advance(now_s)
        self._target_c = target_c

    def body_c(self, now_s: float) -> float:
        """Return how warm it truly is at a time [C]."""
        self._advance(now_s)
        return self._body_c

    def measured_c(self, now_s: float) -> float:
        """Return what its sensor shows at a time [C]."""
        self._advance(now_s)
        return self._sensor_c

    @property
    def target_c(self) -> float | None:
        """What it is regulated to [C], None if off."""
        return self._target_c

    def _advance(self, now_s: float) -> None:
        while self._now_s < now_s:
            if self._at_rest():
                self._now_s = now_s
                return
            step_s = min(STEP_S, now_s - self._now_s)
            self._step(step_s)
            # the last step is what is left: without this, rounding could leave one of zero length for ever
            self._now_s = now_s if step_s < STEP_S else self._now_s + step_s

    def _at_rest(self) -> bool:
        cold = max(abs(self._body_c - self.room_c), abs(self._sensor_c - self.room_c)) < RESTING_C
        return cold and self._target_c is None and self.stuck_at_s == inf

    def _step(self, step_s: float) -> None:
        cooled_c = self.room_c + (self._body_c - self.room_c) * exp(-step_s / self._cooling_s)
        before_c = self._body_c
        if self._now_s >= self.stuck_at_s:
            self._body_c += self.rate_c_s * step_s
        elif self._target_c is None or self._now_s >= self.broken_at_s:
            self._body_c = cooled_c
        else:
            asked_c_s = min(self.rate_c_s, (self._target_c - self._sensor_c) / self._tau_s)
            self._body_c = max(cooled_c, self._body_c + asked_c_s * step_s)
        self.hottest_c = max(self.hottest_c, self._body_c)
        seen_c = self.room_c if self._now_s >= self.sensor_loose_at_s else (before_c + self._body_c) / 2
        self._sensor_c = seen_c + (self._sensor_c - seen_c) * exp(-step_s / self._lag_s)
