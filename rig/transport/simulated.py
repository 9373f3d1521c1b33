"""A line to a virtual device in the same process, on a virtual clock, which beside real devices is a paced one."""

from planner.errors import RigError
from rig.transport.clock import VirtualClock
from rig.virtual.device import VirtualDevice


class SimulatedTransport:
    """Carries bytes to and from a virtual device without loss; waiting moves the clock to the device's next event."""

    def __init__(self, device: VirtualDevice, clock: VirtualClock) -> None:
        self._device = device
        self._clock = clock
        self._open = True

    @property
    def clock(self) -> VirtualClock:
        """Clock that this line's waits move."""
        return self._clock

    def write(self, data: bytes) -> None:
        """Hand bytes to the device now.

        Raises:
            RigError: if the line was closed.
        """
        self._check_open()
        self._device.receive(data, self._clock.now_s())

    def read(self, timeout_s: float) -> bytes:
        """Return what the device has sent, moving the clock up to `timeout_s` [s] for the first byte.

        Raises:
            RigError: if the line was closed.
        """
        self._check_open()
        end_s = self._clock.now_s() + timeout_s
        while not (data := self._device.send(self._clock.now_s())):
            now_s = self._clock.now_s()
            if now_s >= end_s:
                break
            # An event may change nothing on the wire, so that the next one is sought; it is never in the past.
            self._clock.advance_to(min(end_s, self._device.next_event_s(now_s)))
        return data

    def close(self) -> None:
        """Give the line back; closing twice is harmless."""
        self._open = False

    def _check_open(self) -> None:
        if not self._open:
            raise RigError("The line to the simulated device is closed: open the rig again.")
