"""A virtual UV lamp that takes a while to become bright, as those with a discharge do."""

from math import exp

from rig.transport.transport import Clock


class VirtualLamp:
    """Lamp behind a switch, at first dark; its brightness after being turned on is 1 - exp(-t / tau)."""

    def __init__(self, clock: Clock, *, tau_s: float = 0.0) -> None:
        self.burnt_out = False
        """Fault: it stays dark."""
        self._clock = clock
        self._tau_s = tau_s
        self._on_s: float | None = None
        self._dose_s = 0.0

    def switch(self, *, on: bool) -> None:
        """Turn it on or off; what is so already stays so."""
        if on and self._on_s is None:
            self._on_s = self._clock.now_s()
        elif not on and self._on_s is not None:
            self._dose_s, self._on_s = self.dose_s(), None

    @property
    def shines(self) -> bool:
        """Whether light comes out of it."""
        return self._on_s is not None and not self.burnt_out

    def brightness(self) -> float:
        """Return how bright it is now, as a fraction of its full brightness."""
        if not self.shines:
            return 0.0
        return 1.0 if self._tau_s == 0 else 1 - exp(-self._on_for_s() / self._tau_s)

    def dose_s(self) -> float:
        """Return the light given since the beginning, as seconds at full brightness."""
        if not self.shines:
            return self._dose_s
        on_s = self._on_for_s()
        missing_s = 0.0 if self._tau_s == 0 else self._tau_s * (1 - exp(-on_s / self._tau_s))
        return self._dose_s + on_s - missing_s

    def _on_for_s(self) -> float:
        return self._clock.now_s() - (self._on_s or 0.0)
