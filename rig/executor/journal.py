"""The write-ahead journal of a run: what is about to be done, and what was verified, each on the disk before going on.

One JSON object a line. A line that a crash tore is cut off when the journal is taken up again; nothing that was
acknowledged is ever in such a line.
"""

import fcntl
import json
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

from planner.errors import InputError, RigError

JOURNAL_FILE = "journal.jsonl"


class Journal:
    """Journal in a folder, for this process alone."""

    def __init__(self, path: str | Path) -> None:
        """Open a journal to append to, and cut a torn last line off.

        Raises:
            RigError: if the file cannot be written or another run has it.
        """
        self.path = Path(path)
        try:
            self._file = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o644)
        except OSError as error:
            raise RigError(f"Journal {path} cannot be written ({error.strerror}): name another folder.") from error
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            os.close(self._file)
            raise RigError(f"Journal {path} is in use by another run: let it end, or name another folder.") from error
        written = self.path.read_bytes()
        try:
            os.ftruncate(self._file, written.rfind(b"\n") + 1)
            folder = os.open(self.path.parent, os.O_RDONLY)
            os.fsync(folder)
            os.close(folder)
        except OSError as error:
            self.close()
            raise self._full(error) from error

    def write(self, entry: dict[str, Any]) -> None:
        """Append an entry and return when it is on the disk.

        Raises:
            RigError: if it cannot be written; then nothing of it must be done.
        """
        data = json.dumps(entry, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode() + b"\n"
        size = os.fstat(self._file).st_size
        try:
            while data:
                data = data[os.write(self._file, data) :]
            os.fsync(self._file)
        except OSError as error:
            with suppress(OSError):  # what was written of it would spoil the next entry
                os.ftruncate(self._file, size)
            raise self._full(error) from error

    def close(self) -> None:
        """Give the file back; closing twice is harmless."""
        if self._file >= 0:
            with suppress(OSError):
                os.close(self._file)
            self._file = -1

    def _full(self, error: OSError) -> RigError:
        return RigError(f"Journal {self.path} cannot be written ({error.strerror}): free the disk, then resume.")


def read_journal(path: str | Path) -> list[dict[str, Any]]:
    """Return the entries of a journal, without a torn last line.

    Raises:
        InputError: if it cannot be read, or a line before the last is damaged.
    """
    try:
        lines = Path(path).read_bytes().split(b"\n")
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); name the folder of a run") from None
    entries = []
    for number, line in enumerate(lines[:-1], start=1):  # what stands behind the last line end is torn
        try:
            entry = json.loads(line)
        except ValueError:
            entry = None
        if not isinstance(entry, dict) or "event" not in entry:
            raise InputError(f"{path}: line {number} is damaged; do not resume this run, begin anew in another folder")
        entries.append(entry)
    return entries
