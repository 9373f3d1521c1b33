"""A virtual pneumatic extruder: a valve that lets ink flow at a constant rate."""

from rig.transport.transport import Clock


class VirtualExtruder:
    """Valve before a nozzle, at first closed."""

    def __init__(self, clock: Clock, *, flow_ml_min: float) -> None:
        self.flow_ml_min = flow_ml_min
        """True flow through the open valve [mL/min]; a clogged nozzle has less."""
        self._clock = clock
        self._opened_s: float | None = None
        self._out_ml = 0.0

    def switch(self, *, on: bool) -> None:
        """Open or close the valve; what is so already stays so."""
        if on and self._opened_s is None:
            self._opened_s = self._clock.now_s()
        elif not on and self._opened_s is not None:
            self._out_ml, self._opened_s = self.out_ml(), None

    @property
    def flows(self) -> bool:
        """Whether the valve is open."""
        return self._opened_s is not None

    def out_ml(self) -> float:
        """Return how much ink came out since the beginning [mL]."""
        if self._opened_s is None:
            return self._out_ml
        return self._out_ml + self.flow_ml_min / 60 * (self._clock.now_s() - self._opened_s)
