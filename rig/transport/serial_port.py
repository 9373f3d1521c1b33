"""A line to a device on a serial port: a real one or a pseudo-terminal."""

from typing import Any, Literal

import serial

from planner.errors import RigError
from rig.transport.clock import WallClock

SLICE_S = 0.02  # a read waits in slices: setting a new timeout would reconfigure the port each time
WRITE_S = 2.0


Framing = Literal["8N1", "7E1"]
"""Data bits, parity (none, even), stop bits."""


class SerialTransport:
    """Serial port without flow control, for this process alone."""

    def __init__(self, port: str, baud: int, *, framing: Framing = "8N1") -> None:
        """Open a port; boards of the Arduino class restart when that happens.

        Raises:
            RigError: if the port is not there, busy or not permitted.
        """
        self._name = port
        self._clock = WallClock()
        try:
            # pyserial sets DTR when it opens and lets pass that a pseudo-terminal has none (ENOTTY).
            self._port: Any = serial.Serial(
                port,
                baud,
                bytesize=int(framing[0]),
                parity=framing[1],
                timeout=SLICE_S,
                write_timeout=WRITE_S,
                exclusive=True,
            )
        except (OSError, ValueError) as error:
            raise RigError(
                f"Serial port {port} cannot be opened ({error}): check the cable, the name and who else uses it."
            ) from error

    @property
    def clock(self) -> WallClock:
        """The wall's clock."""
        return self._clock

    def write(self, data: bytes) -> None:
        """Send bytes.

        Raises:
            RigError: if the port is gone or does not take them within two seconds.
        """
        try:
            self._port.write(data)
        except (OSError, TypeError) as error:
            raise self._lost(error) from error

    def read(self, timeout_s: float) -> bytes:
        """Return what has arrived, waiting for the first byte up to `timeout_s` [s]; empty if nothing came.

        Raises:
            RigError: if the port is gone.
        """
        end_s = self._clock.now_s() + timeout_s
        try:
            while True:
                waiting = self._port.in_waiting
                if waiting:
                    return self._port.read(waiting)
                if self._clock.now_s() >= end_s:
                    return b""
                if first := self._port.read(1):
                    return first + self._port.read(self._port.in_waiting)
        except (OSError, TypeError) as error:  # pyserial meets a closed port with a TypeError
            raise self._lost(error) from error

    def close(self) -> None:
        """Give the port back; closing twice is harmless."""
        self._port.close()

    def _lost(self, error: Exception) -> RigError:
        return RigError(f"Serial port {self._name} is gone ({error}): check the cable, then home and resume.")
