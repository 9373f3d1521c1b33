"""The receive buffer of a virtual Grbl and the line that grows out of it."""

from collections import deque

from rig.virtual.grbl_gcode import LINE_CHARACTERS


class Receiver:
    """Bytes that came and were not looked at yet; those that find the buffer full are lost without a word."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.lost_bytes = 0
        self._bytes: deque[int] = deque()
        self._line = bytearray()

    @property
    def free(self) -> int:
        """Number of bytes that still fit."""
        return self.size - len(self._bytes)

    def put(self, byte: int) -> None:
        """Take a byte if it fits."""
        if self.free > 0:
            self._bytes.append(byte)
        else:
            self.lost_bytes += 1

    def take_line(self) -> bytes | None:
        """Move bytes into the line up to its end, and return it if that was there."""
        while self._bytes:
            byte = self._bytes.popleft()
            if byte in b"\r\n":
                line = bytes(self._line)
                self._line.clear()
                return line
            if len(self._line) <= 4 * LINE_CHARACTERS:  # blanks and comments do not count as too long
                self._line.append(byte)
        return None

    def clear(self) -> None:
        """Forget all bytes and the line that has begun."""
        self._bytes.clear()
        self._line.clear()
