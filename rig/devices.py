"""What the rig asks of its devices.

Verbs are idempotent: a device that is already there, on or off stays so. Setting and waiting are separate: `set_*`
and `turn_*` return at once, `wait_*` returns when it is done and raises `RigError` after its deadline. Nothing toggles.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from planner.errors import RigError
from planner.program import Pass


@dataclass(frozen=True, kw_only=True)
class Sighting:
    """Where a stage was seen on its way."""

    position_mm: tuple[float, float, float]
    """Film frame [mm]."""
    held: bool
    """Whether it was held up: somebody pressed the feed hold, or a door was opened."""


Watch = Callable[[Sighting], None]
"""Is shown the stage while it moves; what it raises stops the stage."""


@runtime_checkable
class Stage(Protocol):
    """Three-axis stage with the scratch post; x, y in the film frame, z up from the film's surface [mm]."""

    @property
    def late_s(self) -> float | None:
        """How much longer the last moves took than by the kinematics [s]; None if nothing tells."""
        ...

    def home(self) -> None:
        """Find the reference position; any earlier position is void until then."""
        ...

    def lift(self) -> None:
        """Raise the post to the clearance height."""
        ...

    def move_to(self, x_mm: float, y_mm: float) -> None:
        """Start moving the lifted post over a point [mm]."""
        ...

    def scratch(self, stroke: Pass) -> None:
        """Lower the post at the first point of a pass and start moving along it at its speeds."""
        ...

    def wait_idle(self, deadline_s: float, watch: Watch | None = None) -> None:
        """Wait until every move is executed, not merely accepted [s]; show it to `watch` on the way."""
        ...

    def position_mm(self) -> tuple[float, float, float]:
        """Return where the post really is [mm]."""
        ...

    def lower(self, height_mm: float) -> None:
        """Start lowering the lifted post straight down to a height over the film's surface [mm]."""
        ...

    def say_stop(self) -> None:
        """Tell it to stop and wait for nothing; `stop` makes sure."""
        ...

    def stop(self) -> None:
        """Stop moving; the position is kept where the controller can do that."""
        ...


class LoadUnknownError(RigError):
    """What is in the chamber is not known any more, until it was emptied or weighed."""


@runtime_checkable
class PostLoad(Protocol):
    """Water chamber over the post, filled by a syringe pump."""

    def set_load(self, load_g: float) -> None:
        """Start pumping towards a load [g]."""
        ...

    def wait_settled(self, deadline_s: float) -> None:
        """Wait until the dose is pumped and its volume is verified [s]."""
        ...

    def load_g(self) -> float:
        """Return the load from the volume really pumped [g]."""
        ...

    def keep_alive(self) -> None:
        """Let the pump know that somebody listens, while something else is waited for during a dose."""
        ...

    def prime(self, load_g: float) -> None:
        """Take the load as known [g], after the chamber was emptied or weighed."""
        ...

    def doubt(self, why: str) -> LoadUnknownError:
        """Take the load for unknown, and return the error that says so."""
        ...

    def say_stop(self) -> None:
        """Tell it to stop and wait for nothing; `stop` makes sure."""
        ...

    def stop(self) -> None:
        """Stop pumping; the load stays as it is."""
        ...


@runtime_checkable
class Extruder(Protocol):
    """Deposits a layer of ink, before any scratching."""

    @property
    def deposited_ml(self) -> float | None:
        """Volume of the last layer [mL], None if nothing tells."""
        ...

    def deposit(self, outline_mm: tuple[tuple[float, float], ...], thickness_mm: float) -> None:
        """Start covering a region [mm] with ink of a thickness [mm]."""
        ...

    def wait_deposited(self, deadline_s: float) -> None:
        """Wait until the layer lies [s]; called right after `deposit`, since it may be what ends the flow."""
        ...

    def stop(self) -> None:
        """Stop the flow of ink."""
        ...


@runtime_checkable
class UvLamp(Protocol):
    """Lamp that cures a layer."""

    def turn_on(self) -> None:
        """Shine."""
        ...

    def turn_off(self) -> None:
        """Be dark."""
        ...


@runtime_checkable
class WarmsUp(Protocol):
    """What shines or works at full strength only some time after it was turned on; a lamp may be such."""

    def wait_warm(self, deadline_s: float, look: Callable[[], None] | None = None) -> None:
        """Wait until it works at full strength [s]; what `look` raises now and then ends the waiting."""
        ...


@runtime_checkable
class SwitchedByHand(Protocol):
    """What is off only when somebody says so: `turn_off` asks for it and does not wait."""

    def wait_off(self) -> None:
        """Wait for the word that it is off."""
        ...


@runtime_checkable
class HotAir(Protocol):
    """Hot-air gun that resets a layer to polydomain."""

    def set_temperature(self, temperature_c: float) -> None:
        """Blow air of a temperature [C]."""
        ...

    def wait_temperature(self, deadline_s: float, look: Callable[[float], None] | None = None) -> None:
        """Wait until the air has the temperature that was set [s]; show it to `look` on the way [C]."""
        ...

    def temperature_c(self) -> float:
        """Return the air's temperature [C]; asked for now and then, since a watch may depend on it."""
        ...

    def turn_off(self) -> None:
        """Stop blowing and heating."""
        ...


@runtime_checkable
class HotPlate(Protocol):
    """Plate that actuates the finished film."""

    def set_temperature(self, temperature_c: float) -> None:
        """Heat towards a temperature [C]."""
        ...

    def wait_temperature(self, deadline_s: float, look: Callable[[float], None] | None = None) -> None:
        """Wait until the plate has the temperature that was set [s]; show it to `look` on the way [C]."""
        ...

    def temperature_c(self) -> float:
        """Return the plate's temperature [C]; asked for now and then, since a watch may depend on it."""
        ...

    def turn_off(self) -> None:
        """Stop heating."""
        ...


@runtime_checkable
class Enclosure(Protocol):
    """Housing that keeps the lamp's light in."""

    def is_closed(self) -> bool:
        """Return whether its switch says that it is closed."""
        ...


@runtime_checkable
class Balance(Protocol):
    """Balance beside the film, that weighs what the post presses with."""

    def zero(self) -> None:
        """Take what lies on the pan for nothing, once that rests."""
        ...

    def load_g(self) -> float:
        """Return the weight on the pan, once that rests [g]."""
        ...


@runtime_checkable
class ForceGauge(Protocol):
    """Measures what the post really presses with; the counters of a pump only know what was pumped."""

    def force_g(self) -> float:
        """Return the load on the film while the post is down [g]."""
        ...


@runtime_checkable
class Operator(Protocol):
    """The person at the machine."""

    def confirm(self, question: str) -> bool:
        """Ask, and return whether the answer was a clear yes; silence and anything else are no."""
        ...

    def tell(self, text: str) -> None:
        """Say something that needs no answer."""
        ...
