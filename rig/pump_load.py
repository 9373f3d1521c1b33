"""The post's load by a New Era pump: doses of water, each audited by the pump's own counters.

The load adds up every dose, so that one lost or doubled would stay for good. Therefore the only truth is `DIS`: the
load is what the counters say was moved, a dose is the difference to it, and `RUN` is never said again before the
counters have shown that it was not heard.
"""

import logging
from dataclasses import dataclass
from typing import Final

from planner.errors import InputError, RigError
from rig.devices import LoadUnknownError
from rig.dialects.new_era import (
    Alarm,
    Dispensed,
    Status,
    number,
    volume_argument,
    volume_ml,
    volume_units,
)
from rig.pump_audit import PumpAudit
from rig.pump_link import TRIES, PumpLink
from rig.transport import Transport

POLL_S: Final = 0.5
LONGER: Final = 1.5
"""Times that a dose may take as long as its rate tells."""
LATER_S: Final = 10.0
"""Time that it may take beyond that [s]."""
FED_SHARE: Final = 0.25
"""Share of the watchdog's time after which it is fed."""
SMALLEST_ML: Final = 0.0005
"""Doses below half a step of the counters are left out [mL]."""
PUMPING: Final = frozenset({Status.INFUSING, Status.WITHDRAWING, Status.PURGING, Status.TIMED_PAUSE, Status.WAITING})

_ALARMS: Final = {
    Alarm.STALL: "the pump stalled; free the syringe and the tube",
    Alarm.TIME_OUT: "the pump heard nothing for too long and stopped itself; check the cable",
    Alarm.PROGRAM_ERROR: "the pump found its program wrong; clear it on its keys",
    Alarm.PHASE_OUT_OF_RANGE: "the pump ran out of its program; clear it on its keys",
}
_log = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class PumpSetup:
    """What the driver must know of the pump and of what hangs on it."""

    syringe_diameter_mm: float
    rate_ml_min: float
    ml_per_g: float
    load_g_max: float
    address: int = 0
    watchdog_s: int = 30
    """Silence after which the pump stops itself; 0 is the basic mode, without watchdog and checksums."""
    tolerance_ml: float = 0.005
    """Largest difference between the dose asked for and the dose counted."""
    settle_s: float = 1.0
    """Time for the water to come to rest behind the plunger."""


@dataclass(frozen=True, kw_only=True)
class AuditedLoad:
    """A load and the pump's counters that belong to it; what a later run needs to go on from there."""

    load_g: float
    counters: Dispensed


@dataclass(frozen=True, kw_only=True)
class _Dose:
    asked_ml: float
    from_ml: float


class PumpLoad:
    """Water chamber over the post; a `PostLoad`. The port is first used by the first verb, or by `connect`.

    Args:
        transport: line to the pump.
        setup: pump, syringe and limits.
        start: load at the start [g]; or what was last audited, to take up a run that was cut off, perhaps in a dose.
    """

    def __init__(self, transport: Transport, setup: PumpSetup, *, start: float | AuditedLoad = 0.0) -> None:
        self.identity = ""
        """What the pump says that it is, once connected."""
        self._setup = setup
        self._link = PumpLink(transport, address=setup.address, watchdog_s=setup.watchdog_s)
        self._audit = PumpAudit(
            self._link,
            rate_ml_min=setup.rate_ml_min,
            slack_ml=setup.tolerance_ml,
            trusting=setup.watchdog_s > 0,
        )
        if isinstance(start, AuditedLoad):
            self._audit.water_ml = start.load_g * setup.ml_per_g
            self._audit.counters = start.counters
            self._audit.may_have_pumped = True
        else:
            self._audit.water_ml = start * setup.ml_per_g
        self._dose: _Dose | None = None
        self._heard_s = float("-inf")
        """When the pump was last asked for its counters while it pumped."""

    @property
    def audited(self) -> AuditedLoad | None:
        """What the last audit found, without asking the pump; None if there was none or the load is not known."""
        if self._audit.counters is None or self._audit.unknown is not None:
            return None
        return AuditedLoad(load_g=self._audit.water_ml / self._setup.ml_per_g, counters=self._audit.counters)

    def connect(self) -> None:
        """Identify the pump, stop it and tell it the syringe; does nothing if that is done.

        Raises:
            RigError: if it is no such pump, does not take its settings, or the load is not known any more.
        """
        if self.identity and not self._audit.was_reset:
            return
        identity = self._link.open()
        fresh = self._audit.counters is None
        try:
            self._set_up(fresh=fresh)
        except RigError:
            if fresh:  # whatever was counted belongs to no load
                self._audit.counters = None
            raise
        self.identity = identity
        self._audit.was_reset = False
        _log.info("pump: %s at address %d", identity, self._setup.address)

    def _set_up(self, *, fresh: bool) -> None:
        if fresh and self._link.ask("DIS").status is not Status.STOPPED:
            self._audit.unknown = "the pump was in the middle of a dose when it was connected"
        self._halt()
        # Phase 2 ends the program; a pump that comes back from a power failure must not go on by itself, and one
        # that does not know the command never does.
        self._link.say_once("PF0")
        for name, value in (("PHN", "2"), ("FUN", "STP"), ("PHN", "1"), ("FUN", "RAT")):
            self._link.ensure(name, value, value)
        self._ensure_syringe()
        if fresh:
            self._audit.counters = None  # a new diameter starts them anew
        self._audit.update()

    def set_load(self, load_g: float) -> None:
        """Start pumping the difference between a load [g] and the present one.

        Raises:
            InputError: if the load is out of range.
            RigError: if the pump fails, or the present load is not known.
        """
        if not 0 <= load_g <= self._setup.load_g_max:
            raise InputError(
                f"pump: load_g is {load_g:g}, allowed is 0 to {self._setup.load_g_max:g}; change the Program's loads"
            )
        self._ready()
        water_ml = load_g * self._setup.ml_per_g
        if self._dose is not None and abs(self._dose.from_ml + self._dose.asked_ml - water_ml) < SMALLEST_ML:
            return
        self._halt()
        self._dose = None
        change_ml = water_ml - self._audit.water_ml
        if abs(change_ml) < SMALLEST_ML:
            return
        self._audit.clear_full_counters(abs(change_ml))
        self._ensure_syringe()
        direction = "INF" if change_ml > 0 else "WDR"
        self._link.ensure("DIR", direction, direction)
        units = volume_units(self._link.ask("VOL").data)
        volume = volume_argument(abs(change_ml), units)
        self._link.ask("VOL" + volume)  # even if it seems to be set, since that answer may be damaged
        self._link.ensure("VOL", volume, volume + units)
        self._ready()  # the pump may have been reset meanwhile
        status = self._audit.update()
        if status is not Status.STOPPED or abs(water_ml - self._audit.water_ml - change_ml) > SMALLEST_ML:
            raise RigError("pump: it pumps without having been told to; check that nobody works on its keys")
        asked_ml = volume_ml(volume + units)
        self._dose = _Dose(asked_ml=asked_ml if change_ml > 0 else -asked_ml, from_ml=self._audit.water_ml)
        self._start(self._dose)

    def wait_settled(self, deadline_s: float) -> None:
        """Wait until the dose is pumped and counted, and the water has come to rest [s].

        Raises:
            RigError: if it takes longer, or another volume than asked for was moved; `load_g` tells which.
        """
        self._ready()
        if self._dose is None:
            return
        clock, dose = self._link.clock, self._dose
        # a rate that was lowered on the pump's keys must not keep the layer waiting
        deadline_s = min(deadline_s, LONGER * abs(dose.asked_ml) / self._setup.rate_ml_min * 60.0 + LATER_S)
        end_s = clock.now_s() + deadline_s
        while self._audit.update() in PUMPING or self._audit.update_surely() in PUMPING:
            if clock.now_s() >= end_s:
                raise RigError(f"pump: {self._progress(dose)} in {deadline_s:g} s; check the rate, then stop the pump")
            clock.sleep(POLL_S)
        self._dose = None
        alarm = self._audit.alarm
        if alarm is None and abs(self._audit.water_ml - dose.from_ml) < SMALLEST_ML:
            # As after a loss of power, should its alarm have been lost as well.
            raise self._audit.lose("the pump's counters show nothing of a dose that it began")
        self._audit.end_dose()
        if abs(self._audit.water_ml - dose.from_ml - dose.asked_ml) > self._setup.tolerance_ml:
            cause = "something stopped it; look at its keys" if alarm is None else _ALARMS[alarm]
            raise RigError(f"pump: {self._progress(dose)}: {cause}, then set the load again")
        clock.sleep(self._setup.settle_s)

    def load_g(self) -> float:
        """Return the load from the volume really pumped [g].

        Raises:
            RigError: if the pump fails, or the load is not known.
        """
        self._ready()
        self._audit.update()
        self._heard_s = self._link.clock.now_s()
        return self._audit.water_ml / self._setup.ml_per_g

    def keep_alive(self) -> None:
        """Feed the pump's watchdog, while something else is waited for during a dose; cheap if asked often.

        Raises:
            RigError: if the pump fails.
        """
        silent_s = self._link.clock.now_s() - self._heard_s
        if 0.0 < FED_SHARE * self._setup.watchdog_s < silent_s:
            self.load_g()

    def doubt(self, why: str) -> LoadUnknownError:
        """Take the load for unknown, and return the error that says so."""
        return self._audit.lose(why)

    def say_stop(self) -> None:
        """Tell the pump to stop and wait for nothing; one that was not connected was told nothing yet.

        Raises:
            RigError: if the line is gone.
        """
        if self.identity:
            self._link.tell("STP")

    def stop(self) -> None:
        """Stop pumping; the load stays as it is.

        Raises:
            RigError: if the pump does not confirm that it stands still.
        """
        self.connect()
        self._link.say_once("STP")
        self._halt()
        self._dose = None

    def prime(self, load_g: float) -> None:
        """Take the load as known [g], after the chamber was emptied or weighed.

        Raises:
            RigError: if the pump fails.
        """
        self._audit.unknown = self._audit.unknown or "the priming was not finished"
        self._audit.counters = None
        self._audit.end_dose()
        self._dose = None
        self.connect()
        self._halt()
        self._audit.water_ml = load_g * self._setup.ml_per_g
        self._audit.unknown = None

    def _ready(self) -> None:
        self.connect()
        if self._audit.unknown is not None:
            self._dose = None
            raise self._audit.unknown_error(self._audit.unknown)

    def _ensure_syringe(self) -> None:
        diameter = number(self._setup.syringe_diameter_mm)
        self._link.ensure("DIA", diameter, diameter)
        rate = number(self._setup.rate_ml_min) + "MM"
        self._link.ensure("RAT", rate, rate)

    def _start(self, dose: _Dose) -> None:
        """Say RUN, and again only if the counters show that it was not heard."""
        self._audit.begin_dose(dose.from_ml + dose.asked_ml)
        for _ in range(TRIES):
            reply = self._link.say_once("RUN")
            if reply is not None and reply.answers("RUN") and reply.status in PUMPING:
                return
            if self._audit.update_surely() is not Status.STOPPED:
                return
            if abs(self._audit.water_ml - dose.from_ml) > SMALLEST_ML:
                return
            _log.warning("pump: RUN was answered by %s and not heard, by the counters", reply)
        self._dose = None
        self._audit.end_dose()
        raise RigError("pump: it does not start to pump; look at its display")

    def _halt(self) -> None:
        """Stop the pump, unless it stands still; the first STP pauses, the second ends."""
        for _ in range(TRIES):
            if self._audit.update_surely() is Status.STOPPED:
                self._audit.end_dose()
                return
            self._link.say_once("STP")
        raise RigError("pump: it does not stop; switch it off")

    def _progress(self, dose: _Dose) -> str:
        moved_ml = self._audit.water_ml - dose.from_ml
        return f"{moved_ml:.3f} mL of {dose.asked_ml:.3f} mL were moved"
