"""A virtual heater as its driver sees it, without a wire between them."""

from rig.transport.transport import Clock
from rig.virtual.heater import VirtualHeater


class SimulatedThermostat:
    """Heater in the same process, on a clock."""

    def __init__(self, heater: VirtualHeater, clock: Clock) -> None:
        self._heater = heater
        self._clock = clock

    def regulate(self, temperature_c: float) -> None:
        """Heat towards a temperature [C]."""
        self._heater.regulate(temperature_c, self._clock.now_s())

    def read_c(self) -> float:
        """Return the temperature that its sensor shows [C]."""
        return self._heater.measured_c(self._clock.now_s())

    def switch_off(self) -> None:
        """Stop heating."""
        self._heater.regulate(None, self._clock.now_s())
