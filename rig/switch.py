"""The seam to what is only on or off: a lamp's relay, an extruder's valve."""

from typing import Protocol


class Switch(Protocol):
    """Something with two states."""

    def switch(self, *, on: bool) -> None:
        """Turn it on or off; what is so already stays so.

        Raises:
            RigError: if it cannot be reached.
        """
        ...
