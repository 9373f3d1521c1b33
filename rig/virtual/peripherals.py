"""Simulated devices without a wire: they do what they are told, in the time it takes."""

from rig.transport import Clock

DEPOSIT_S = 60.0
WARM_C_S = 2.0
"""How fast plate and air become hot [C/s]."""
ROOM_C = 25.0


class SimulatedExtruder:
    """Covers a region with ink; `layers_mm` has the thickness of each layer that lies."""

    def __init__(self, clock: Clock) -> None:
        self.layers_mm: list[float] = []
        self._clock = clock
        self._wanted_mm: float | None = None

    def deposit(self, outline_mm: tuple[tuple[float, float], ...], thickness_mm: float) -> None:
        """Start to cover a region [mm]."""
        self._wanted_mm = thickness_mm

    def wait_deposited(self, deadline_s: float) -> None:
        """Wait until the layer lies [s]."""
        self._clock.sleep(DEPOSIT_S)
        if self._wanted_mm is not None:
            self.layers_mm.append(self._wanted_mm)
        self._wanted_mm = None

    def stop(self) -> None:
        """Stop the flow of ink."""
        self._wanted_mm = None


class SimulatedLamp:
    """Lamp that counts how long it shone."""

    def __init__(self, clock: Clock) -> None:
        self.shone_s: list[float] = []
        """How long it shone, each time [s]."""
        self._clock = clock
        self._since_s: float | None = None

    @property
    def is_on(self) -> bool:
        """Whether it shines."""
        return self._since_s is not None

    def turn_on(self) -> None:
        """Shine."""
        if self._since_s is None:
            self._since_s = self._clock.now_s()

    def turn_off(self) -> None:
        """Be dark."""
        if self._since_s is not None:
            self.shone_s.append(self._clock.now_s() - self._since_s)
        self._since_s = None


class SimulatedHeater:
    """Hot air or hot plate."""

    def __init__(self, clock: Clock) -> None:
        self.is_on = False
        self._clock = clock
        self._wanted_c = ROOM_C

    def set_temperature(self, temperature_c: float) -> None:
        """Heat towards a temperature [C]."""
        self.is_on, self._wanted_c = True, temperature_c

    def wait_temperature(self, deadline_s: float) -> None:
        """Wait until it is reached [s]."""
        self._clock.sleep((self._wanted_c - ROOM_C) / WARM_C_S)

    def temperature_c(self) -> float:
        """Return the temperature [C]."""
        return self._wanted_c if self.is_on else ROOM_C

    def turn_off(self) -> None:
        """Stop heating."""
        self.is_on = False


class SimulatedEnclosure:
    """Box that is closed unless a test opens it."""

    def __init__(self) -> None:
        self.closed = True

    def is_closed(self) -> bool:
        """Return whether it is closed."""
        return self.closed
