"""A job: what was asked, how far it is, what came out; kept in a folder of its own."""

import json
import re
import secrets
import shutil
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any, Literal

from pydantic import ValidationError

from planner.errors import InputError
from scenes.output import write_json
from scenes.studio.request import HOT, PLAN, STEPS, JobRequest
from scenes.whole_file import whole_file

REQUEST_FILE, STATE_FILE, LOG_FILE, PROGRESS_FILE = "request.json", "state.json", "log.txt", "progress.jsonl"
RESULT_FILE = "result.json"
ID = re.compile(r"\d{8}-\d{6}-[0-9a-f]{8}")
"""Date, time and eight random digits."""

State = Literal["queued", "running", "done", "failed", "cancelled"]
RUNS: tuple[State, ...] = ("queued", "running")

DOWNLOADS = {
    "program.json": (PLAN, "program.json"),
    "plan.png": (PLAN, "plan.png"),
    "search.png": (f"{PLAN}.progress", "current.png"),
    "report.html": (HOT, "report.html"),
    "shape.ply": (HOT, "shape.ply"),
    "result.json": (HOT, "result.json"),
}
"""Files that may be fetched, by the name in their address."""


@dataclass(kw_only=True)
class Job:
    """One job and where it stands."""

    id: str
    number: int
    """Counts the jobs of a workspace, from 1."""
    folder: Path
    request: JobRequest
    owner: str
    """Digest that stands for the browser which started it."""
    created: str
    """Date and time, local."""
    state: State = "queued"
    message: str = ""
    """What went wrong, one sentence a line."""
    step: str = ""
    """Folder of the step that runs or ran last."""
    stages: dict[str, float] = field(default_factory=dict)
    """Share done of each stage of the present step, in their order."""
    note: str = ""
    """Words about the present stage."""

    @property
    def title(self) -> str:
        """A few words that tell it from others."""
        return f"{self.number}: {self.request.title}"

    @property
    def waits_or_runs(self) -> bool:
        """Say whether it is not over."""
        return self.state in RUNS

    def result(self) -> dict[str, Any] | None:
        """Return what `lce predict` found, None before."""
        path = self.folder / HOT / RESULT_FILE
        return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None

    def log_tail(self, lines: int) -> str:
        """Return the last lines that the commands wrote."""
        path = self.folder / LOG_FILE
        if not path.is_file():
            return ""
        return "\n".join(path.read_text(encoding="utf-8", errors="replace").splitlines()[-lines:])

    def download(self, name: str) -> Path | None:
        """Return the file of a name that may be fetched, None if there is none."""
        if name not in DOWNLOADS:
            return None
        path = self.folder.joinpath(*DOWNLOADS[name])
        return path if path.is_file() else None

    def save(self) -> None:
        """Write where it stands, whole or not at all."""
        content = {"state": self.state, "message": self.message, "step": self.step}
        with whole_file(self.folder / STATE_FILE) as path:
            write_json(path, content)

    def remove_step(self) -> None:
        """Remove what the present step may have left: each writes into a folder of its own."""
        if self.step in STEPS:
            for name in (self.step, f"{self.step}.progress"):
                shutil.rmtree(self.folder / name, ignore_errors=True)


def new_job(jobs: Path, number: int, request: JobRequest, owner: str) -> Job:
    """Make a job and its folder."""
    now = datetime.now().astimezone()
    job_id = f"{now:%Y%m%d-%H%M%S}-{secrets.token_hex(4)}"
    folder = jobs / job_id
    folder.mkdir()
    created = f"{now:%Y-%m-%d %H:%M}"
    job = Job(id=job_id, number=number, folder=folder, request=request, owner=owner, created=created)
    asked = {"number": number, "owner": owner, "created": created, "request": request.model_dump(exclude_none=True)}
    with whole_file(folder / REQUEST_FILE) as path:
        write_json(path, asked)
    job.save()
    return job


def load_job(folder: Path) -> Job | None:
    """Read a job from its folder; None if this is none.

    A job that was not over when its studio ended is over now: nobody works on it any more.

    Raises:
        InputError: if its files cannot be read.
    """
    if not ID.fullmatch(folder.name) or not (folder / STATE_FILE).is_file():
        return None
    try:
        asked = json.loads((folder / REQUEST_FILE).read_text(encoding="utf-8"))
        stands = json.loads((folder / STATE_FILE).read_text(encoding="utf-8"))
        job = Job(
            id=folder.name,
            number=asked["number"],
            folder=folder,
            request=JobRequest.model_validate(asked["request"]),
            owner=asked["owner"],
            created=asked["created"],
            **stands,
        )
    except (OSError, ValueError, KeyError, TypeError, ValidationError) as error:
        raise InputError(f"--workspace: {folder} is not a job's ({error}); remove the folder.") from error
    if job.waits_or_runs:
        job.remove_step()
        job.state, job.message = "cancelled", "The studio ended before this was finished; start it again."
        job.save()
    return job
