"""The UV lamp behind a switch."""

from collections.abc import Callable
from typing import Final

from planner.errors import RigError
from rig.switch import Switch
from rig.transport import Clock

LOOK_S: Final = 1.0
"""Time between two looks at whatever must hold while it warms up [s]."""


class SwitchedLamp:
    """Lamp that is turned on and off as a whole; a `UvLamp` that `WarmsUp`.

    Args:
        switch: its relay.
        clock: time for the warming up.
        warm_up_s: time from turning it on until it has its full brightness [s]; 0 for diodes.
    """

    def __init__(self, switch: Switch, clock: Clock, *, warm_up_s: float) -> None:
        self._switch = switch
        self._clock = clock
        self._warm_up_s = warm_up_s
        self._warm_s: float | None = None

    def turn_on(self) -> None:
        """Shine; a lamp that is on already does not start to warm up anew.

        Raises:
            RigError: if the switch cannot be reached.
        """
        self._switch.switch(on=True)
        if self._warm_s is None:
            self._warm_s = self._clock.now_s() + self._warm_up_s

    def wait_warm(self, deadline_s: float, look: Callable[[], None] | None = None) -> None:
        """Wait until it has its full brightness [s]; what `look` raises now and then ends the waiting.

        Raises:
            RigError: if it is off, or the warming up takes longer.
        """
        if self._warm_s is None:
            raise RigError("The lamp is off, so that it does not become warm: turn it on first.")
        left_s = self._warm_s - self._clock.now_s()
        if left_s > deadline_s:
            raise RigError(
                f"The lamp needs {left_s:.0f} s more to become warm and was given {deadline_s:g} s: allow more time."
            )
        while (left_s := self._warm_s - self._clock.now_s()) > 0:
            self._clock.sleep(min(LOOK_S, left_s))
            if look is not None:
                look()

    def turn_off(self) -> None:
        """Be dark.

        Raises:
            RigError: if the switch cannot be reached.
        """
        self._switch.switch(on=False)
        self._warm_s = None
