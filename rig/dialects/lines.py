"""Bytes to lines, for devices that answer in lines of printable ASCII."""

from typing import Final

LONGEST: Final = 80
"""Longest line with its end [bytes]; what NAMUR and MT-SICS devices say is shorter."""


class LineParser:
    """Bytes from a device that answers in lines to those lines, without blanks around them.

    Never raises; keeps at most one unfinished line; lines that are empty, too long or not printable ASCII are dropped.
    """

    def __init__(self, *, longest: int = LONGEST) -> None:
        """Expect lines of at most so many bytes."""
        self._longest = longest
        self.discarded = 0
        """Lines so far that were dropped, but for empty ones."""
        self._line = bytearray()

    def feed(self, data: bytes) -> list[str]:
        """Take bytes and return the lines that they complete."""
        *ended, rest = data.replace(b"\r", b"\n").split(b"\n")
        lines: list[str] = []
        for part in ended:
            self._keep(part)
            if (text := self._take()) is not None:
                lines.append(text)
        self._keep(rest)
        return lines

    def forget(self) -> None:
        """Drop the line that has begun, after the device was silent."""
        self._line.clear()

    def _keep(self, part: bytes) -> None:
        self._line += part[: self._longest + 1 - len(self._line)]

    def _take(self) -> str | None:
        raw = bytes(self._line)
        self._line.clear()
        if len(raw) > self._longest or any(not 0x20 <= byte <= 0x7E for byte in raw):
            self.discarded += 1
            return None
        return raw.decode("ascii").strip() or None
