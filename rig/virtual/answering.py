"""What virtual devices with lines share: lines cut out of the bytes that come, answers that go out a little later."""

from typing import Final

ANSWER_S: Final = 0.02
LONGEST_LINE: Final = 256


class LineInbox:
    """Bytes that came, up to the next line end; what is longer than a line can be is dropped."""

    def __init__(self) -> None:
        self._bytes = bytearray()

    def take(self, data: bytes) -> list[str]:
        """Take bytes and return the lines that they complete."""
        self._bytes += data
        *lines, rest = bytes(self._bytes).replace(b"\r", b"\n").split(b"\n")
        self._bytes = bytearray(rest[-LONGEST_LINE:])
        return [text for line in lines if (text := line.decode("latin-1").strip())]


class Outbox:
    """Answers that wait for their time."""

    def __init__(self) -> None:
        self._entries: list[tuple[float, bytes]] = []

    def put(self, data: bytes, due_s: float) -> None:
        """Send bytes at a time [s]."""
        self._entries.append((due_s, data))

    def due(self, now_s: float) -> bytes:
        """Return what was to be sent up to a time [s], each once."""
        ready = b"".join(data for due_s, data in self._entries if due_s <= now_s)
        self._entries = [entry for entry in self._entries if entry[0] > now_s]
        return ready

    def next_s(self) -> float:
        """Return when the next bytes are to be sent [s]; infinite if none are."""
        return min((due_s for due_s, _ in self._entries), default=float("inf"))
