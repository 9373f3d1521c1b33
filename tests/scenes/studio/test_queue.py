"""Jobs: their turn, their end, and what they leave; the commands are stood in for by a small program."""

import asyncio
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from planner.errors import InputError
from scenes.studio import queue, step_process
from scenes.studio.job import LOG_FILE, PROGRESS_FILE, Job, load_job
from scenes.studio.queue import JobQueue
from scenes.studio.request import HOT, PLAN, JobRequest
from scenes.studio.workspace import Workspace

COMMAND = """
import json, os, pathlib, signal, subprocess, sys, time
behaviour, step, out = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[5])
out.mkdir()
pathlib.Path(f"{out}.progress").mkdir()
for share in (0.0, 0.5, 1.0):
    line = json.dumps({"stage": step, "share": share, "note": ""}) + "\\n"
    os.write(int(os.environ["LCE_PROGRESS_FD"]), line.encode())
print("said by", step, flush=True)
if step == "predict" and behaviour == "fails":
    (out / "half").touch()
    sys.exit("lce: " + sys.argv[3] + " is wrong; correct it.")
if step == "predict" and behaviour in ("hangs", "stubborn"):
    if behaviour == "stubborn":
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
    (out / "half").write_text(str(child.pid))
    time.sleep(60)
pathlib.Path(f"{out}.progress").rmdir()
(out / "whole").touch()
"""
OWNER, OTHER = "me", "another"


@pytest.fixture
def behave(monkeypatch):
    """Let the commands be stood in for by one that works, fails, hangs or is stubborn in its second step."""
    monkeypatch.setattr(step_process, "ENDINGS", tuple((sign, 1.0) for sign, _ in step_process.ENDINGS))

    def behave_as(behaviour: str) -> None:
        monkeypatch.setattr(
            queue, "command_line", lambda arguments: [sys.executable, "-c", COMMAND, behaviour, *arguments]
        )

    behave_as("works")
    return behave_as


def apart(work):
    """Run a coroutine in a thread of its own: where a browser was tested before, this one's event loop is taken."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, work).result()


def submit(jobs: JobQueue, owner: str = OWNER) -> Job:
    return jobs.submit(JobRequest(scene="face"), owner)


async def until(condition, patience_s: float = 20.0) -> None:
    """Wait until something holds."""
    ends = time.monotonic() + patience_s
    while not condition():
        assert time.monotonic() < ends, "it never happened"
        await asyncio.sleep(0.01)


def is_over(*jobs: Job):
    return lambda: not any(job.waits_or_runs for job in jobs)


def is_alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().split()[2] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_a_job_runs_its_steps_and_keeps_what_they_say(tmp_path, behave):
    async def work() -> Job:
        jobs = JobQueue(Workspace(tmp_path))
        job = submit(jobs)
        await until(is_over(job))
        return job

    job = apart(work())
    assert (job.state, job.message) == ("done", "")
    assert {PLAN, HOT} <= names(job.folder)
    assert job.log_tail(10).splitlines() == ["said by plan", "said by predict"]
    assert len((job.folder / PROGRESS_FILE).read_text().splitlines()) == 6
    assert job.stages == {"predict": 1.0}


def test_jobs_wait_for_their_turn(tmp_path, behave):
    async def work() -> tuple[list[str], int]:
        jobs = JobQueue(Workspace(tmp_path), at_once=1)
        several = [submit(jobs) for _ in range(3)]
        order, most = [], 0
        while any(job.waits_or_runs for job in several):
            running = [job for job in several if job.state == "running"]
            most = max(most, len(running))
            order += [job.id for job in running if job.id not in order]
            await asyncio.sleep(0.005)
        assert order == [job.id for job in several]
        return [job.state for job in several], most

    assert apart(work()) == (["done"] * 3, 1)


@pytest.mark.parametrize("behaviour", ["hangs", "stubborn"])
def test_a_cancelled_job_leaves_nothing_half_written_and_nothing_running(tmp_path, behave, behaviour):
    behave(behaviour)

    async def work() -> tuple[Job, int]:
        jobs = JobQueue(Workspace(tmp_path))
        job = submit(jobs)
        half = job.folder / HOT / "half"
        await until(lambda: half.is_file() and half.read_text() != "")
        child = int(half.read_text())
        await jobs.cancel(job.id, OWNER)
        return job, child

    job, child = apart(work())
    assert job.state == "cancelled"
    assert names(job.folder) == {"request.json", "state.json", LOG_FILE, PROGRESS_FILE, PLAN}
    assert names(job.folder / PLAN) == {"whole"}
    # a signal that cannot be refused takes a moment on a busy machine, too
    apart(until(lambda: not is_alive(child), patience_s=5.0))


def test_a_job_that_waits_is_cancelled_and_never_begins(tmp_path, behave):
    behave("hangs")

    async def work() -> tuple[Job, Job]:
        jobs = JobQueue(Workspace(tmp_path))
        first, second = submit(jobs), submit(jobs)
        await until(lambda: first.step == HOT)
        await jobs.cancel(second.id, OWNER)
        await jobs.cancel(first.id, OWNER)
        await asyncio.sleep(0.05)
        return first, second

    first, second = apart(work())
    assert (first.state, second.state) == ("cancelled", "cancelled")
    assert names(second.folder) == {"request.json", "state.json"}


def test_only_the_browser_that_started_a_job_cancels_it(tmp_path, behave):
    behave("hangs")

    async def work() -> None:
        jobs = JobQueue(Workspace(tmp_path))
        job = submit(jobs)
        with pytest.raises(InputError, match="another browser"):
            await jobs.cancel(job.id, OTHER)
        with pytest.raises(InputError, match="no job"):
            await jobs.cancel("absent", OWNER)
        assert job.waits_or_runs
        await jobs.close()
        assert job.state == "cancelled"

    apart(work())


def test_a_job_that_fails_tells_the_commands_sentence_and_keeps_whole_steps(tmp_path, behave):
    behave("fails")

    async def work() -> Job:
        jobs = JobQueue(Workspace(tmp_path))
        job = submit(jobs)
        await until(is_over(job))
        return job

    job = apart(work())
    assert (job.state, job.message) == ("failed", f"{job.folder / PLAN} is wrong; correct it.")
    assert {PLAN, HOT} & names(job.folder) == {PLAN}


def test_closing_ends_all_jobs_and_opening_anew_finds_them(tmp_path, behave):
    behave("hangs")

    async def work() -> None:
        jobs = JobQueue(Workspace(tmp_path), at_once=2)
        several = [submit(jobs) for _ in range(3)]
        await until(lambda: sum(job.step == HOT for job in several) == 2)
        await jobs.close()
        assert [job.state for job in several] == ["cancelled"] * 3

    apart(work())
    found = list(JobQueue(Workspace(tmp_path)).jobs.values())
    assert [(job.number, job.state, job.owner) for job in found] == [(n, "cancelled", OWNER) for n in (1, 2, 3)]
    assert all("closed" in job.message for job in found)


def test_a_job_that_outlived_its_studio_is_over_and_its_half_step_is_gone(tmp_path, behave):
    async def work() -> Job:
        jobs = JobQueue(Workspace(tmp_path))
        job = submit(jobs)
        await until(is_over(job))
        return job

    job = apart(work())
    job.state, job.step = "running", HOT
    job.save()
    found = load_job(job.folder)
    assert found is not None
    assert (found.state, "ended" in found.message) == ("cancelled", True)
    assert HOT not in names(job.folder)
    assert PLAN in names(job.folder)


def test_a_folder_that_is_no_job_is_told(tmp_path, behave):
    workspace = Workspace(tmp_path)
    (workspace.jobs / "20260101-000000-00000000").mkdir()
    (workspace.jobs / "20260101-000000-00000000" / "state.json").write_text("{")
    with pytest.raises(InputError, match="remove the folder"):
        workspace.load_jobs()
