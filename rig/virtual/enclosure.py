"""A virtual enclosure: its door, and the switch on it."""


class VirtualEnclosure:
    """Enclosure that is closed until someone opens it; an `Enclosure`."""

    def __init__(self) -> None:
        self.door_is_closed = True
        """The door itself; tests open it."""
        self.switch_is_stuck = False
        """Fault: the switch says closed whatever the door does."""

    def is_closed(self) -> bool:
        """Return whether its switch says that it is closed."""
        return self.door_is_closed or self.switch_is_stuck
