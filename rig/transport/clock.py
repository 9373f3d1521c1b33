"""The clocks of the rig: one that is told what time it is, the wall's, and one in step with it."""

import time

_CLOCK = getattr(time, "CLOCK_BOOTTIME", time.CLOCK_MONOTONIC)
"""Where the system has it, the one that goes on while the computer is suspended: an uncured layer ages then, too."""


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
    """Monotonic time of this computer; setting the date does not move it, sleep of a suspended laptop counts."""

    def now_s(self) -> float:
        """Return the time since some fixed moment [s]."""
        return time.clock_gettime(_CLOCK)

    def sleep(self, duration_s: float) -> None:
        """Let time pass [s]."""
        time.sleep(max(0.0, duration_s))


class PacedClock(VirtualClock):
    """Virtual time that passes so many times as fast as the wall's, so that a person can watch or real devices join."""

    def __init__(self, pace: float) -> None:
        super().__init__()
        self._wall = WallClock()
        self._pace = pace
        self._begun_s = self._wall.now_s()

    def now_s(self) -> float:
        """Return the time since the clock was made [s]."""
        self._now_s = max(self._now_s, (self._wall.now_s() - self._begun_s) * self._pace)
        return self._now_s

    def sleep(self, duration_s: float) -> None:
        """Let time pass [s]."""
        self.advance_to(self.now_s() + duration_s)

    def advance_to(self, time_s: float) -> None:
        """Wait until it is a time [s]; one that is past changes nothing."""
        self._wall.sleep((time_s - self.now_s()) / self._pace)
        super().advance_to(time_s)
