"""What a run shows while it goes on."""

from dataclasses import dataclass
from typing import Protocol

from rig.executor.operations import Operation


@dataclass(frozen=True, kw_only=True)
class Moment:
    """The present state of a run."""

    operation: Operation
    count: int
    """Number of operations."""
    at_s: float
    """Time since the run began [s]."""
    position_mm: tuple[float, float, float] | None
    load_g: float | None
    temperature_c: float | None
    left_s: float
    """Time until the end, by the kinematic model [s]."""
    pausing: bool
    """Whether somebody wishes a pause, which comes after this operation."""


class View(Protocol):
    """Somebody who looks on."""

    def begin(self, moment: Moment) -> None:
        """See an operation begin."""
        ...

    def move(self, moment: Moment) -> None:
        """See the stage move, or something warm up or be waited for."""
        ...

    def clear(self) -> None:
        """Show nothing until the next moment, since the operator is asked something."""
        ...


class Unseen:
    """Nobody looks on."""

    def begin(self, moment: Moment) -> None:
        """See nothing."""

    def move(self, moment: Moment) -> None:
        """See nothing."""

    def clear(self) -> None:
        """Show nothing, as ever."""
