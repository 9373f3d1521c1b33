"""The sections of a rig's file, with their bounds."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from planner.program.operations import Strict
from rig.dialects.namur import WATCHDOG_S
from rig.virtual.post import PostQuality

Attended = Literal["simulated", "operator"]
Positive = Annotated[float, Field(gt=0)]


class Line(Strict):
    """How one controller is reached."""

    transport: Literal["simulated", "serial"]
    port: Annotated[str, Field(min_length=1)] | None = None
    """Serial port, best by its identity under /dev/serial/by-id."""
    baud: Annotated[int, Field(gt=0)]

    @model_validator(mode="after")
    def _reachable(self) -> Self:
        if self.transport == "serial" and self.port is None:
            raise ValueError('port is missing, allowed with transport = "serial" is the name of a port')
        return self


class StageLine(Line):
    """The stage's controller."""

    controller: Literal["grbl", "marlin"] = "grbl"
    baud: Annotated[int, Field(gt=0)] = 115200
    origin_mm: tuple[float, float, float]
    """Machine position of the film's centre, at the film's surface [mm]."""
    steps_per_mm: tuple[Positive, Positive, Positive] = (400.0, 400.0, 400.0)
    travel_mm: tuple[Positive, Positive, Positive] = (200.0, 200.0, 60.0)
    """Machine positions go from minus this to 0 with Grbl, and from 0 to this with Marlin [mm]."""
    homing_feed_mm_s: Positive = 1.0
    homing_seek_mm_s: Positive = 20.0
    homing_pull_off_mm: Positive = 1.0
    pace_tolerance_s: Annotated[float, Field(ge=0.02)] | None = None
    """How much longer than by its kinematics a stroke may take [s]; without it that is told and not a failure."""

    @property
    def reach_mm(self) -> tuple[tuple[float, float], ...]:
        """Lowest and highest machine position of each axis [mm]."""
        return tuple((-far, 0.0) if self.controller == "grbl" else (0.0, far) for far in self.travel_mm)

    @model_validator(mode="after")
    def _known_pace(self) -> Self:
        if self.controller == "marlin" and self.pace_tolerance_s is not None:
            raise ValueError('pace_tolerance_s is set, allowed is that with controller = "grbl" only; leave it out')
        return self


class PumpLine(Line):
    """The pump, and the syringe in it."""

    baud: Annotated[int, Field(gt=0)] = 19200
    address: Annotated[int, Field(ge=0, le=99)] = 0
    mode: Literal["safe", "basic"] = "safe"
    watchdog_s: Annotated[int, Field(ge=10, le=255)] = 30
    """Silence after which the pump stops itself, in safe mode [s]."""
    syringe_diameter_mm: Annotated[float, Field(ge=0.1, le=50)]
    tolerance_ml: Annotated[float, Field(ge=0.002)] = 0.005
    """Largest difference between the dose asked for and the dose counted."""
    settle_s: Annotated[float, Field(ge=0)] = 1.0


class HotPlateLine(Line):
    """A hot plate that speaks NAMUR."""

    baud: Annotated[int, Field(gt=0)] = 9600
    watchdog_s: Annotated[int, Field(ge=WATCHDOG_S[0], le=WATCHDOG_S[1])] = 60
    """Silence after which the plate stops heating by itself [s]."""


class BalanceLine(Line):
    """A balance that speaks MT-SICS, beside the film in the stage's reach, on whose pan the post is weighed."""

    baud: Annotated[int, Field(gt=0)] = 9600
    at_mm: tuple[float, float]
    """The pan's centre in the film frame [mm]."""
    pan_mm: float
    """Height to which the post is lowered on the pan, over the film's surface and a little below the pan's [mm]."""
    tolerance_g: Annotated[float, Field(ge=0.01)] = 0.1
    """How far the weighed load may be from the one that the pump counted."""


class Deposition(Strict):
    """The extruder's flow."""

    flow_ml_min: Annotated[float, Field(gt=0, le=100)]
    """Through the open valve, found by weighing what comes out in a minute [mL/min]."""


class Curing(Strict):
    """The lamp's light."""

    warm_up_s: Annotated[float, Field(ge=0, le=1800)] = 0.0
    """Time until it has its full brightness [s]; 0 for diodes."""


class Heating(Strict):
    """What is expected of everything that heats; what does not do so is turned off."""

    rise_c: Annotated[float, Field(gt=0, le=50)] = 5.0
    """Least warming within `within_s`, or half of what is missing if that is less."""
    within_s: Annotated[float, Field(ge=5, le=600)] = 60.0
    tolerance_c: Annotated[float, Field(gt=0, le=20)] = 2.0
    """How near counts as reached."""
    overshoot_c: Annotated[float, Field(gt=0, le=50)] = 15.0
    """How much hotter than told, or once reached colder, is a failure."""


class Interlocks(Strict):
    """What must hold before something dangerous or spoiling is begun."""

    uv_needs_closed_enclosure: bool = True
    hot_air_needs_lifted_post: bool = True
    load_change_needs_lifted_post: bool = True


class Simulated(Strict):
    """How good the simulated parts of a rig are."""

    pump_lag_s: Positive = 0.3
    """Time in which the water follows the plunger [s]."""
    pump_leak: Annotated[float, Field(ge=0, lt=1)] = 0.0
    """Share of the pumped water that does not get into the chamber, unseen by the pump's counters."""
    post_friction_g: Annotated[float, Field(ge=0)] = PostQuality.friction_g
    """Dry friction in the post's guide: half the difference between loading and unloading [g]."""
    post_lag_s: Annotated[float, Field(ge=0)] = PostQuality.lag_s
    post_noise_g: Annotated[float, Field(ge=0)] = PostQuality.noise_g
    """Standard deviation of the post's force [g]."""
    seed: Annotated[int, Field(ge=0)] = 0
    pace: Annotated[float, Field(ge=0)] = 0.0
    """How many times as fast as the wall's the simulated time passes; 0 is as fast as it can be computed."""
