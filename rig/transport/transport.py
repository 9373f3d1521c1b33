"""The one seam between drivers and devices: bytes out, bytes in, and a clock."""

from typing import Protocol


class Clock(Protocol):
    """Time as the rig knows it: the machine's own on a simulated rig, the wall's on a real one."""

    def now_s(self) -> float:
        """Return the time since some fixed moment [s]; it never goes back."""
        ...

    def sleep(self, duration_s: float) -> None:
        """Let time pass [s]."""
        ...


class Transport(Protocol):
    """A line to one device. The drivers above it do not know what is at its other end."""

    @property
    def clock(self) -> Clock:
        """Clock that this line's waits run on."""
        ...

    def write(self, data: bytes) -> None:
        """Send bytes.

        Raises:
            RigError: if the line is gone or does not take them in time.
        """
        ...

    def read(self, timeout_s: float) -> bytes:
        """Return what has arrived, waiting for the first byte up to `timeout_s` [s]; empty if nothing came.

        Raises:
            RigError: if the line is gone.
        """
        ...

    def close(self) -> None:
        """Give the line back; closing twice is harmless."""
        ...
