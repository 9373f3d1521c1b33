"""What heats, under a watch: the hot-air gun and the hot plate."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Final, Protocol

from planner.errors import InputError, RigError
from rig.heating_watch import HeatingLimits, HeatingWatch
from rig.transport import Clock

POLL_S: Final = 1.0


class Thermostat(Protocol):
    """The seam to a heater that regulates itself."""

    def regulate(self, temperature_c: float) -> None:
        """Heat towards a temperature [C].

        Raises:
            RigError: if it cannot be reached or does not take the temperature.
        """
        ...

    def read_c(self) -> float:
        """Return the temperature that its sensor shows [C].

        Raises:
            RigError: if it cannot be reached.
        """
        ...

    def switch_off(self) -> None:
        """Stop heating.

        Raises:
            RigError: if it cannot be reached.
        """
        ...


class HeatedDevice:
    """Heater that is turned off as soon as it does not behave; a `HotAir` and a `HotPlate`.

    Nothing here runs by itself: the watch sees what `wait_temperature` and `temperature_c` see, so that whoever holds
    a temperature asks for it now and then.

    Args:
        thermostat: the heater.
        clock: time for the watch.
        name: how it is called in messages.
        temperature_c_max: the highest temperature that may be set [C].
        limits: what the watch expects.
    """

    def __init__(
        self, thermostat: Thermostat, clock: Clock, *, name: str, temperature_c_max: float, limits: HeatingLimits
    ) -> None:
        self._thermostat = thermostat
        self._clock = clock
        self._name = name
        self._max_c = temperature_c_max
        self._limits = limits
        self._target_c: float | None = None
        self._watch: HeatingWatch | None = None

    def set_temperature(self, temperature_c: float) -> None:
        """Heat towards a temperature [C]; one that is set already stays so.

        Raises:
            InputError: if it is out of bounds.
            RigError: if the heater cannot be reached.
        """
        if not 0 < temperature_c <= self._max_c:
            raise InputError(
                f"{self._name}: temperature_c is {temperature_c:g}, allowed is above 0 to {self._max_c:g}; change the"
                " Program's temperatures or the machine file"
            )
        if temperature_c == self._target_c:
            return
        with self._off_on_failure():
            start_c = self._thermostat.read_c()
            self._thermostat.regulate(temperature_c)
            self._target_c = temperature_c
            self._watch = HeatingWatch(
                name=self._name,
                target_c=temperature_c,
                limits=self._limits,
                now_s=self._clock.now_s(),
                start_c=start_c,
            )

    def wait_temperature(self, deadline_s: float, look: Callable[[float], None] | None = None) -> None:
        """Wait until it has the temperature that was set [s]; show what is measured on the way [C] to `look`.

        Raises:
            RigError: if it is off, not there in time, cannot be reached, or the watch is not content; then it is off.
        """
        if self._watch is None:
            raise RigError(f"The {self._name} is off, so that it does not become warm: set a temperature first.")
        watch, end_s = self._watch, self._clock.now_s() + deadline_s
        with self._off_on_failure():
            while True:
                measured_c = self._look()
                if look is not None:
                    look(measured_c)
                if watch.reached:
                    return
                if self._clock.now_s() >= end_s:
                    raise RigError(
                        f"The {self._name} has {measured_c:.1f} C and not {self._target_c:g} C after {deadline_s:g} s"
                        " and is off now: allow more time, or check its element."
                    )
                self._clock.sleep(min(POLL_S, max(0.0, end_s - self._clock.now_s())))

    def temperature_c(self) -> float:
        """Return its temperature [C].

        Raises:
            RigError: if it cannot be reached, or the watch is not content; then it is off.
        """
        with self._off_on_failure():
            return self._look()

    def turn_off(self) -> None:
        """Stop heating.

        Raises:
            RigError: if it cannot be reached.
        """
        self._target_c, self._watch = None, None
        self._thermostat.switch_off()

    def _look(self) -> float:
        measured_c = self._thermostat.read_c()
        if self._watch is not None:
            self._watch.look(self._clock.now_s(), measured_c)
        return measured_c

    @contextmanager
    def _off_on_failure(self) -> Iterator[None]:
        try:
            yield
        except RigError:
            with suppress(RigError):  # the first failure is the one to tell
                self.turn_off()
            raise
