"""The wire log: every byte of a line with its direction and time, always on, to be read after a disconnect."""

import json
import logging
from contextlib import suppress
from pathlib import Path
from typing import Literal, TextIO

from planner.errors import RigError
from rig.transport.transport import Clock, Transport

_log = logging.getLogger(__name__)

Way = Literal["out", "in"]


class LoggedTransport:
    """Line whose bytes are also appended to a JSONL file: `{"t_s": 1.25, "way": "out", "bytes": "?"}`.

    Bytes stand as the characters of the same numbers (Latin-1), so that the log is lossless and can be read.
    """

    def __init__(self, line: Transport, path: str | Path) -> None:
        """Append to a file.

        Raises:
            RigError: if the file cannot be written.
        """
        self._line = line
        self._path = Path(path)
        try:
            self._file: TextIO | None = self._path.open("a", encoding="utf-8", buffering=1)
        except OSError as error:
            raise RigError(
                f"Wire log {path} cannot be written ({error}): free the disk or name another file."
            ) from error

    @property
    def clock(self) -> Clock:
        """Clock of the line inside."""
        return self._line.clock

    def write(self, data: bytes) -> None:
        """Send bytes, then log them.

        Raises:
            RigError: if the line is gone, or once if the log cannot be written.
        """
        self._line.write(data)
        self._record("out", data)

    def read(self, timeout_s: float) -> bytes:
        """Return and log what has arrived, waiting for the first byte up to `timeout_s` [s].

        Raises:
            RigError: if the line is gone, or once if the log cannot be written.
        """
        data = self._line.read(timeout_s)
        if data:
            self._record("in", data)
        return data

    def close(self) -> None:
        """Give the line back and close the file; closing twice is harmless."""
        self._line.close()
        if self._file is not None:
            self._file.close()
            self._file = None

    def _record(self, way: Way, data: bytes) -> None:
        if self._file is None:
            return
        entry = {"t_s": round(self.clock.now_s(), 6), "way": way, "bytes": data.decode("latin-1")}
        try:
            self._file.write(json.dumps(entry) + "\n")
        except OSError as error:
            # Said once: a full disk must not keep the driver from stopping its device.
            with suppress(OSError):
                self._file.close()
            self._file = None
            _log.warning("wire log %s ends here: %s", self._path, error)
            raise RigError(
                f"Wire log {self._path} cannot be written any more ({error}): free the disk, then resume."
            ) from error


def read_wire_log(path: str | Path, way: Way) -> bytes:
    """Return all bytes that went one way, in order; a torn last line is left out."""
    data = bytearray()
    for text in Path(path).read_text(encoding="utf-8").splitlines():
        try:
            entry = json.loads(text)
        except json.JSONDecodeError:
            continue
        if entry["way"] == way:
            data += entry["bytes"].encode("latin-1")
    return bytes(data)
