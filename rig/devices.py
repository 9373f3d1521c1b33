"""What the rig asks of its devices.

Verbs are idempotent: a device that is already there, on or off stays so. Setting and waiting are separate: `set_*`
and `turn_*` return at once, `wait_*` returns when it is done and raises `RigError` after its deadline. Nothing toggles.
"""

from typing import Protocol, runtime_checkable

from planner.program import Pass


@runtime_checkable
class Stage(Protocol):
    """Three-axis stage with the scratch post; x, y in the film frame, z up from the film's surface [mm]."""

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

    def wait_idle(self, deadline_s: float) -> None:
        """Wait until every move is executed, not merely accepted [s]."""
        ...

    def position_mm(self) -> tuple[float, float, float]:
        """Return where the post really is [mm]."""
        ...

    def stop(self) -> None:
        """Stop moving, with the position kept."""
        ...


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

    def stop(self) -> None:
        """Stop pumping; the load stays as it is."""
        ...


@runtime_checkable
class Extruder(Protocol):
    """Deposits a layer of ink, before any scratching."""

    def deposit(self, outline_mm: tuple[tuple[float, float], ...], thickness_mm: float) -> None:
        """Start covering a region [mm] with ink of a thickness [mm]."""
        ...

    def wait_deposited(self, deadline_s: float) -> None:
        """Wait until the layer lies [s]."""
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

    def wait_warm(self, deadline_s: float) -> None:
        """Wait until it works at full strength [s]."""
        ...


@runtime_checkable
class HotAir(Protocol):
    """Hot-air gun that resets a layer to polydomain."""

    def set_temperature(self, temperature_c: float) -> None:
        """Blow air of a temperature [C]."""
        ...

    def wait_temperature(self, deadline_s: float) -> None:
        """Wait until the air has the temperature that was set [s]."""
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

    def wait_temperature(self, deadline_s: float) -> None:
        """Wait until the plate has the temperature that was set [s]."""
        ...

    def temperature_c(self) -> float:
        """Return the plate's temperature [C]."""
        ...

    def turn_off(self) -> None:
        """Stop heating."""
        ...


@runtime_checkable
class Enclosure(Protocol):
    """Housing that keeps the lamp's light in."""

    def closed(self) -> bool:
        """Return whether its switch says that it is closed."""
        ...


@runtime_checkable
class Balance(Protocol):
    """Balance under the post, to calibrate its load."""

    def zero(self) -> None:
        """Take what lies on the pan for nothing, once that rests."""
        ...

    def load_g(self) -> float:
        """Return the weight on the pan, once that rests [g]."""
        ...
