"""What every virtual device is: a state machine over bytes and time, without I/O and without a clock of its own."""

from typing import Protocol


class VirtualDevice(Protocol):
    """One end of a wire. Time is told to it, so that an hour of scratching can pass in seconds."""

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that arrive at a time [s]; times never go back."""
        ...

    def send(self, now_s: float) -> bytes:
        """Return the bytes that the device has sent up to a time [s], each once."""
        ...

    def next_event_s(self, now_s: float) -> float:
        """Return the next time [s] at which the device will do or send something by itself; infinite if never."""
        ...
