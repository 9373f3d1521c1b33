"""A line with faults at chosen bytes: what a bad cable, a weak supply or a pulled plug do."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from planner.errors import RigError
from rig.transport.transport import Clock, Transport


@dataclass(frozen=True, kw_only=True)
class Fault:
    """One fault on one byte."""

    kind: Literal["drop", "flip", "duplicate", "insert", "merge", "delay", "unplug"]
    """What happens to the byte; `merge` drops the next line end from there on, `insert` puts `inserted` before it."""
    way: Literal["out", "in"]
    """To the device or from it."""
    at: int
    """Which byte of that way, counted from 0."""
    bit: int = 0
    """Which bit flips."""
    delay_s: float = 0.0
    """How long the byte and all that follow it are held up [s]."""
    inserted: bytes = b""


class FaultyTransport:
    """Line that passes everything on except at its faults; once unplugged it stays so."""

    def __init__(self, line: Transport, faults: Iterable[Fault]) -> None:
        self._line = line
        ordered = sorted(faults, key=lambda fault: fault.at)
        self._faults = {way: [fault for fault in ordered if fault.way == way] for way in ("out", "in")}
        self._count = {"out": 0, "in": 0}
        self._held = b""
        self._unplugged = False

    @property
    def clock(self) -> Clock:
        """Clock of the line inside."""
        return self._line.clock

    @property
    def pending(self) -> int:
        """Number of faults that have not happened yet."""
        return sum(len(faults) for faults in self._faults.values())

    def write(self, data: bytes) -> None:
        """Send bytes, with the faults that lie in them.

        Raises:
            RigError: if the line is gone.
        """
        self._check()
        while data:
            part, data, wait_s = self._spoil("out", data)
            if part:
                self._line.write(part)
            self._check()
            self.clock.sleep(wait_s)

    def read(self, timeout_s: float) -> bytes:
        """Return what has arrived, with the faults that lie in it.

        Raises:
            RigError: if the line is gone.
        """
        self._check()
        while data := self._held or self._line.read(timeout_s):
            part, self._held, wait_s = self._spoil("in", data)
            self.clock.sleep(wait_s)
            if part:
                return part
            self._check()
        return b""

    def close(self) -> None:
        """Give the line back; closing twice is harmless."""
        self._line.close()

    def _spoil(self, way: Literal["out", "in"], data: bytes) -> tuple[bytes, bytes, float]:
        """Return what passes, what is left for later, and the time until then [s]."""
        start, faults = self._count[way], self._faults[way]
        if not faults or faults[0].at >= start + len(data):
            self._count[way] += len(data)
            return data, b"", 0.0
        fault = faults[0]
        here = max(0, fault.at - start)
        if fault.kind == "merge":
            here = data.find(b"\n", here)
            if here < 0:  # the line end is still to come
                self._count[way] += len(data)
                return data, b"", 0.0
        faults.pop(0)
        before, byte, after = data[:here], data[here : here + 1], data[here + 1 :]
        self._count[way] += here
        if fault.kind == "unplug":
            self._unplugged = True
            return before, b"", 0.0
        if fault.kind == "delay":
            return before, byte + after, fault.delay_s
        self._count[way] += 1
        changed = {
            "drop": b"",
            "merge": b"",
            "flip": bytes([byte[0] ^ (1 << fault.bit)]),
            "duplicate": byte + byte,
            "insert": fault.inserted + byte,
        }[fault.kind]
        return before + changed, after, 0.0

    def _check(self) -> None:
        if self._unplugged:
            raise RigError("The line is gone (unplugged): check the cable, then home and resume.")
