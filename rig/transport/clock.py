"""The two clocks of the rig: one that is told what time it is, and the wall's."""

import time


class VirtualClock:
    """Time that passes only when someone waits, so that an hour of scratching takes seconds.

    Lines to several devices may share one: a wait on one of them is a wait for all.
    """

    def __init__(self) -> None:
        self._now_s = 0.0

    def now_s(self) -> float:
        """Return the time since the clock was made [s]."""
        return self._now_s

    def sleep(self, duration_s: float) -> None:
        """Let time pass [s]."""
        self.advance_to(self._now_s + duration_s)

    def advance_to(self, time_s: float) -> None:
        """Let it become a time [s]; one that is past changes nothing."""
        self._now_s = max(self._now_s, time_s)


class WallClock:
    """Monotonic time of this computer; setting the date does not move it."""

    def now_s(self) -> float:
        """Return the time since some fixed moment [s]."""
        return time.monotonic()

    def sleep(self, duration_s: float) -> None:
        """Let time pass [s]."""
        time.sleep(max(0.0, duration_s))

    def advance_to(self, time_s: float) -> None:
        """Wait until a time [s]; one that is past is not waited for."""
        self.sleep(time_s - self.now_s())
