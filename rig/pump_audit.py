"""How much water a pump has really moved, by its own counters, which are the only truth about it."""

import logging
from typing import Final

from planner.errors import RigError
from rig.devices import LoadUnknownError
from rig.dialects.new_era import Alarm, Dispensed, Status, dispensed
from rig.pump_link import TRIES, PumpLink

COUNTER_ML: Final = 9.9
"""Volume [mL] up to which the counters keep their step of 1 uL."""
DECIMALS_ML: Final = 9
"""Decimals of the water [mL], far below a step of the counters."""
_log = logging.getLogger(__name__)


class PumpAudit:
    """The water that was moved, kept up to date with counters that can be cleared, lost and misread.

    Args:
        link: line to the pump.
        rate_ml_min: fastest that the counters can grow.
        slack_ml: how far a counter may seem to go back.
        trusting: whether one answer is enough, as where it has a checksum.
    """

    def __init__(self, link: PumpLink, *, rate_ml_min: float, slack_ml: float, trusting: bool) -> None:
        self.water_ml = 0.0
        """Water in the chamber [mL]."""
        self.counters: Dispensed | None = None
        """Counters that belong to it; without, the next ones are taken for such."""
        self.unknown: str | None = None
        """Why the water is not known, if so."""
        self.alarm: Alarm | None = None
        """What last stopped a dose, other than a loss of power."""
        self.was_reset = False
        """Whether the pump lost its power since this was last set to false."""
        self.may_have_pumped = False
        self._goal_ml: float | None = None
        self._link = link
        self._rate_ml_min = rate_ml_min
        self._slack_ml = slack_ml
        self._trusting = trusting

    def begin_dose(self, goal_ml: float) -> None:
        """Expect the water to move towards a volume [mL], from when on a loss of power loses it."""
        self.alarm = None
        self.may_have_pumped = True
        self._goal_ml = goal_ml

    def end_dose(self) -> None:
        """Expect the water to rest, so that even a loss of power does not lose it."""
        self.may_have_pumped = False
        self._goal_ml = None

    def update_surely(self) -> Status | None:
        """Update by an answer that cannot be an old one.

        Raises:
            RigError: if the pump does not answer, or the water is not known any more.
        """
        self._link.synchronise()
        return self.update()

    def update(self) -> Status | None:
        """Read the counters, add what was moved to the water, and return what the pump is doing.

        Raises:
            RigError: if the pump does not answer, or the water is not known any more.
        """
        status, now = self._read()
        before = now if self.counters is None else self.counters
        alarms = self._link.take_alarms()
        for alarm in alarms - {Alarm.RESET}:
            _log.log(logging.WARNING if self.may_have_pumped else logging.INFO, "pump: alarm %s", alarm.name)
            self.alarm = alarm
        if Alarm.RESET in alarms:
            self.was_reset = True
            if self.may_have_pumped:
                self.counters = now
                raise self.lose("the pump lost its power, and its counters, during a dose")
            if now.infused_ml == now.withdrawn_ml == 0:
                before = now
        lowest = (before.infused_ml - self._slack_ml, before.withdrawn_ml - self._slack_ml)
        if now.infused_ml < lowest[0] or now.withdrawn_ml < lowest[1]:
            self.counters = now
            raise self.lose("the pump's counters went back")
        # The counters are decimals: without the sum's binary remainder, the water does not depend on how often they
        # were asked, nor does the last digit of the next dose.
        water_ml = round(self.water_ml + now.net_ml - before.net_ml, DECIMALS_ML)
        # side by side, with nothing that a signal can interrupt between them: the counters belong to the water
        self.counters, self.water_ml = now, water_ml
        return status

    def clear_full_counters(self, dose_ml: float) -> None:
        """Start the counters anew, with the pump at rest, before a dose makes the pump tell them in coarser steps.

        Raises:
            RigError: if the pump does not do so.
        """
        counters = self.counters
        if counters is None or max(counters.infused_ml, counters.withdrawn_ml) + dose_ml < COUNTER_ML:
            return
        for _ in range(TRIES):
            for direction in ("INF", "WDR"):
                self._link.ask("CLD" + direction)
            _, now = self._read()
            if now.infused_ml == now.withdrawn_ml == 0:
                self.counters = now
                return
        raise RigError("pump: it does not clear its counters; check that nobody works on its keys")

    def lose(self, why: str) -> LoadUnknownError:
        """Take the water for unknown, and return the error that says so."""
        if self._goal_ml is not None:
            low_ml, high_ml = sorted((self.water_ml, self._goal_ml))
            why += f" (the chamber holds between {low_ml:.3f} and {high_ml:.3f} mL)"
        self.unknown = why
        self.end_dose()
        return self.unknown_error(why)

    def unknown_error(self, why: str) -> LoadUnknownError:
        """Return the error that says why the water is unknown and what to do."""
        return LoadUnknownError(
            f"pump: the load is not known, since {why}; empty or weigh the chamber and prime the load anew"
        )

    def _read(self) -> tuple[Status | None, Dispensed]:
        reply = self._link.ask("DIS")
        now = dispensed(reply.data)
        if self._trusting:
            return reply.status, now
        # Nothing guards the basic mode against a flipped bit: two answers in a row have to agree, but for what the
        # pump can have moved between them.
        for _ in range(TRIES):
            asked_s = self._link.clock.now_s()
            again = self._link.ask("DIS")
            before, now = now, dispensed(again.data)
            moved_ml = self._rate_ml_min / 60 * (self._link.clock.now_s() - asked_s) + now.resolution_ml
            changes_ml = (now.infused_ml - before.infused_ml, now.withdrawn_ml - before.withdrawn_ml)
            if again.status is reply.status and all(0 <= change <= 2 * moved_ml for change in changes_ml):
                return again.status, now
            reply = again
        raise RigError("pump: its counters read differently each time; check the cable, or use the safe mode")
