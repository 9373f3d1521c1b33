"""A watch over something that heats: it must become warmer when told to, and never much hotter than told.

Without it a loose sensor or a dead element would let a heater heat without end, or a run wait for ever.
"""

from dataclasses import dataclass

from planner.errors import RigError


@dataclass(frozen=True, kw_only=True)
class HeatingLimits:
    """What is expected of a heater."""

    rise_c: float = 5.0
    """Least warming within `within_s`, or half of what is missing if that is less [C]."""
    within_s: float = 60.0
    tolerance_c: float = 2.0
    """How near counts as reached [C]."""
    overshoot_c: float = 15.0
    """How much hotter than told, or once reached colder, is a failure [C]."""


class HeatingWatch:
    """Looks at the temperatures on the way to one target, in the order of their times."""

    def __init__(self, *, name: str, target_c: float, limits: HeatingLimits, now_s: float, start_c: float) -> None:
        """Begin at a time [s] and a temperature [C]."""
        self.reached = False
        """Whether the target was reached once."""
        self._name = name
        self._target_c = target_c
        self._limits = limits
        self._from_above = start_c > target_c
        self._start_c = start_c
        self._anchor = (now_s, start_c)
        self.look(now_s, start_c)

    def look(self, now_s: float, measured_c: float) -> None:
        """Judge a temperature [C] at a time [s].

        Raises:
            RigError: if it does not rise as expected, is much too hot, or has fallen away from the target.
        """
        missing_c = self._target_c - measured_c
        self.reached = self.reached or abs(missing_c) <= self._limits.tolerance_c
        self._not_too_hot(measured_c)
        if self.reached:
            if missing_c > self._limits.overshoot_c:
                raise self._failure(f"fell to {measured_c:.1f} C after it had reached {self._target_c:g} C")
        elif missing_c > 0:
            self._rises(now_s, measured_c)

    def _not_too_hot(self, measured_c: float) -> None:
        self._from_above = self._from_above and not self.reached
        # a film on a plate that is still hot may cool down to its target, but nothing may heat it further
        expected_c = self._start_c if self._from_above else self._target_c
        if measured_c > expected_c + self._limits.overshoot_c:
            raise self._failure(f"has {measured_c:.1f} C where {self._target_c:g} C were set")

    def _rises(self, now_s: float, measured_c: float) -> None:
        since_s, from_c = self._anchor
        wanted_c = min(self._limits.rise_c, (self._target_c - from_c) / 2)
        if measured_c - from_c >= wanted_c:
            self._anchor = (now_s, measured_c)
        elif now_s - since_s > self._limits.within_s:
            raise self._failure(
                f"rose from {from_c:.1f} to {measured_c:.1f} C in {now_s - since_s:.0f} s, expected are"
                f" {wanted_c:.1f} C in {self._limits.within_s:g} s"
            )

    def _failure(self, what: str) -> RigError:
        return RigError(
            f"The {self._name} {what}: it was told to be off; switch it off at the mains, then check its element and"
            " its sensor."
        )
