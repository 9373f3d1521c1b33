"""The pneumatic extruder: a valve that is open for as long as the volume of a layer takes to flow."""

from itertools import pairwise

from planner.errors import InputError, RigError
from rig.switch import Switch
from rig.transport import Clock

LATE: float = 0.05
"""How much longer than it should the valve may have been open, as a fraction."""
SMALLEST_LATE_S: float = 0.5


class PneumaticExtruder:
    """Extruder that deposits a volume by time; an `Extruder`.

    The valve is closed by `wait_deposited`, so it is called right after `deposit`; what was deposited is told by
    `deposited_ml`, from the time for which the valve was really open.

    Args:
        valve: lets the ink flow.
        clock: time for the flow.
        flow_ml_min: flow through the open valve, measured by weighing what comes out in a minute [mL/min].
    """

    def __init__(self, valve: Switch, clock: Clock, *, flow_ml_min: float) -> None:
        self.deposited_ml: float | None = None
        """Volume of the last layer by the time for which the valve was open [mL], None before the first."""
        self._valve = valve
        self._clock = clock
        self._flow_ml_s = flow_ml_min / 60
        self._opened_s: float | None = None
        self._needed_s = 0.0

    def deposit_s(self, outline_mm: tuple[tuple[float, float], ...], thickness_mm: float) -> float:
        """Return how long it takes to cover a region [mm] with ink of a thickness [mm] [s]."""
        return _area_mm2(outline_mm) * thickness_mm * 1e-3 / self._flow_ml_s

    def deposit(self, outline_mm: tuple[tuple[float, float], ...], thickness_mm: float) -> None:
        """Open the valve for a region [mm] and a thickness [mm]; `wait_deposited` closes it.

        Raises:
            InputError: if there is nothing to cover.
            RigError: if a layer is being deposited, or the valve cannot be reached.
        """
        needed_s = self.deposit_s(outline_mm, thickness_mm)
        if needed_s <= 0:
            raise InputError(
                f"extruder: the layer has an area of {_area_mm2(outline_mm):g} mm2 and a thickness of"
                f" {thickness_mm:g} mm, allowed are both above 0; correct the Program's film"
            )
        if self._opened_s is not None:
            raise RigError("extruder: a layer is being deposited; wait for it or stop it first")
        self._needed_s, self._opened_s = needed_s, self._clock.now_s()
        try:
            self._valve.switch(on=True)
        except RigError:
            self._opened_s = None
            raise

    def wait_deposited(self, deadline_s: float) -> None:
        """Wait until the volume has flowed, and close the valve [s].

        Raises:
            RigError: if it takes longer, with the valve closed then; or the valve was open for too long.
        """
        if self._opened_s is None:
            return
        left_s = self._opened_s + self._needed_s - self._clock.now_s()
        self._clock.sleep(max(0.0, min(left_s, deadline_s)))
        open_s = self._close()
        told = f"{open_s * self._flow_ml_s:.2f} mL of {self._needed_s * self._flow_ml_s:.2f} mL were deposited"
        if left_s > deadline_s:
            raise RigError(f"extruder: {told} in {deadline_s:g} s; allow more time, and take the layer off")
        if open_s > self._needed_s + max(SMALLEST_LATE_S, LATE * self._needed_s):
            raise RigError(f"extruder: {told}, since the valve was closed late; take the layer off")

    def stop(self) -> None:
        """Stop the flow of ink; the layer stays unfinished.

        Raises:
            RigError: if the valve cannot be reached.
        """
        if self._opened_s is None:
            self._valve.switch(on=False)
        else:
            self._close()

    def _close(self) -> float:
        """Close the valve, and return for how long it was open [s]."""
        self._valve.switch(on=False)
        open_s = self._clock.now_s() - (self._opened_s or 0.0)
        self._opened_s, self.deposited_ml = None, open_s * self._flow_ml_s
        return open_s


def _area_mm2(outline_mm: tuple[tuple[float, float], ...]) -> float:
    """Return the area inside a closed line, its first point not repeated, by the shoelace formula [mm2]."""
    closed = (*outline_mm, *outline_mm[:1])
    return abs(sum(a[0] * b[1] - b[0] * a[1] for a, b in pairwise(closed))) / 2
