"""The folder that a studio works in: uploaded files and jobs; of one studio at a time."""

import fcntl
import hashlib
import os
import re
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from planner.errors import InputError
from planner.target import TARGET_SUFFIXES
from scenes.studio.job import Job, load_job

LARGEST_UPLOAD_MB = 64
CALIBRATION_SUFFIXES = (".toml",)
LONGEST_STEM = 40


class Workspace:
    """Where jobs and uploaded files lie."""

    def __init__(self, folder: Path) -> None:
        """Prepare.

        Raises:
            InputError: if the folder cannot be made or written.
        """
        self.folder = Path(folder).absolute()
        self.jobs, self.uploads = self.folder / "jobs", self.folder / "uploads"
        try:
            for path in (self.jobs, self.uploads):
                path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(
                f"--workspace: cannot make {error.filename} ({error.strerror}); name a folder that can be made and "
                "written."
            ) from error

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Keep other studios out; the system releases the lock however this process ends.

        Raises:
            InputError: if another studio is there.
        """
        path = self.folder / ".lock"
        with path.open("a", encoding="utf-8") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                raise InputError(
                    f"--workspace: {self.folder} is open in another studio; use its page, or name another folder."
                ) from error
            yield

    def load_jobs(self) -> list[Job]:
        """Return all jobs, the oldest first.

        Raises:
            InputError: if one cannot be read.
        """
        found = (load_job(path) for path in sorted(self.jobs.iterdir()) if path.is_dir())
        return sorted((job for job in found if job is not None), key=lambda job: job.number)

    def new_upload(self, file_name: str, allowed: tuple[str, ...]) -> Path:
        """Return where to store an uploaded file: a generated folder, and a name of harmless letters.

        Raises:
            InputError: if its suffix is not allowed.
        """
        given = Path(file_name.replace("\\", "/"))
        suffix = given.suffix.lower()
        if suffix not in allowed:
            raise InputError(
                f"upload: {given.name[:80]!r} ends in {suffix or 'nothing'!r}, allowed are {', '.join(allowed)}; "
                "choose such a file."
            )
        stem = re.sub(r"[^A-Za-z0-9_-]+", "_", given.stem).strip("_")[:LONGEST_STEM] or "upload"
        folder = self.uploads / secrets.token_hex(8)
        folder.mkdir()
        return folder / f"{stem}{suffix}"

    def plain(self, text: str) -> str:
        """Return a message with the names of uploaded files instead of their paths here."""
        return re.sub(rf"{re.escape(str(self.uploads))}{re.escape(os.sep)}[0-9a-f]{{16}}{re.escape(os.sep)}", "", text)


def upload_suffixes(kind: str) -> tuple[str, ...]:
    """Return what an uploaded file of a kind, target or calibration, may end in."""
    return CALIBRATION_SUFFIXES if kind == "calibration" else TARGET_SUFFIXES


def owner_of(browser: str) -> str:
    """Return what stands for a browser in files and pages: from it nobody can tell the browser's cookie."""
    return hashlib.sha256(browser.encode()).hexdigest()[:16]
