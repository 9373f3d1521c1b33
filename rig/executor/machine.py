"""All devices of a rig together, and how they are stopped."""

import logging
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

from planner.errors import RigError
from rig.devices import Balance, Enclosure, Extruder, ForceGauge, HotAir, HotPlate, Operator, PostLoad, Stage, UvLamp
from rig.pump_load import AuditedLoad
from rig.transport import Clock

_log = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class Devices:
    """What a run works with."""

    clock: Clock
    stage: Stage
    load: PostLoad
    extruder: Extruder
    lamp: UvLamp
    hot_air: HotAir
    hot_plate: HotPlate
    enclosure: Enclosure
    operator: Operator
    balance: Balance | None = None
    gauge: ForceGauge | None = None
    """What measures the post's force, if anything does."""
    audited_load: Callable[[], AuditedLoad | None]
    """Returns what the last audit of the pump found, without asking it."""
    connect: Callable[[], None]
    """Makes sure that everything around stage and pump that hangs on a line answers."""
    identities: Callable[[], dict[str, str]]
    """Returns what each device says that it is, once they were asked."""

    def stop(self) -> list[str]:
        """Stop everything: motion, pump, ink, air, lamp, heat; return what could not be stopped.

        Motion and pump are told to stop at once and asked only in the end whether they did, so that no dead line keeps
        air, lamp and heat on. Each is tried whatever happened to the ones before. This is no emergency stop: it takes
        seconds, and it needs this computer, the cables and the controllers to work.
        """
        for say_stop in (self.stage.say_stop, self.load.say_stop):
            with suppress(RigError):  # told below, where it is asked for
                say_stop()
        off = self.switch_off()
        return _tried({"stage": self.stage.stop, "pump": self.load.stop}) + off

    def switch_off(self) -> list[str]:
        """Stop ink, air, lamp and heat; return what could not be stopped."""
        return _tried(
            {
                "extruder": self.extruder.stop,
                "hot air": self.hot_air.turn_off,
                "lamp": self.lamp.turn_off,
                "hot plate": self.hot_plate.turn_off,
            }
        )


def _tried(stops: dict[str, Callable[[], None]]) -> list[str]:
    problems = []
    for name, stop in stops.items():
        try:
            stop()
        except RigError as error:
            problems.append(f"{name}: {error}")
            _log.warning("the %s could not be stopped: %s", name, error)
    return problems
