"""The jobs of a studio: so many at once, the others wait their turn."""

import asyncio
import logging

from planner.errors import InputError
from scenes.studio.job import LOG_FILE, PROGRESS_FILE, Job, new_job
from scenes.studio.request import JobRequest, command_line
from scenes.studio.step_process import StepProcess
from scenes.studio.workspace import Workspace

logger = logging.getLogger(__name__)

FINISHED = "done"
"""The last stage that planning tells: the process ends anyway."""
ERROR_MARK = "lce: "
"""What the lines begin with in which a command says what is wrong."""


class JobQueue:
    """Runs jobs and knows all of a workspace."""

    def __init__(self, workspace: Workspace, *, at_once: int = 1) -> None:
        """Read the jobs of a workspace.

        Args:
            workspace: where they lie.
            at_once: so many run at the same time.

        Raises:
            InputError: if a job cannot be read.
        """
        self.workspace = workspace
        self.jobs: dict[str, Job] = {job.id: job for job in workspace.load_jobs()}
        self.version = 0
        """Counts changes, so that pages know when to look again."""
        self._turn = asyncio.Semaphore(at_once)
        self._works: dict[str, asyncio.Task[None]] = {}
        self._processes: dict[str, StepProcess] = {}
        self._leaving: set[str] = set()
        """Jobs that are to end early."""

    def submit(self, request: JobRequest, owner: str) -> Job:
        """Put a job into the queue.

        Raises:
            InputError: if the request has no target.
        """
        request.source(self.workspace.folder)
        number = 1 + max((job.number for job in self.jobs.values()), default=0)
        job = new_job(self.workspace.jobs, number, request, owner)
        self.jobs[job.id] = job
        self._works[job.id] = asyncio.create_task(self._work(job))
        self._changed()
        return job

    async def cancel(self, job_id: str, owner: str) -> None:
        """End a job early and wait until nothing of it runs any more.

        Raises:
            InputError: if there is no such job, or another browser started it.
        """
        job = self.jobs.get(job_id)
        if job is None:
            raise InputError(f"cancel: there is no job {job_id!r}; reload the page.")
        if job.owner != owner:
            raise InputError("cancel: another browser started this job; cancel it there.")
        await self._leave(job, "")

    async def close(self) -> None:
        """End all jobs early."""
        waiting = [job for job in self.jobs.values() if job.waits_or_runs]
        # Those that wait first: none of them shall begin when a running one ends.
        self._leaving.update(job.id for job in waiting)
        await asyncio.gather(*(self._leave(job, "The studio was closed; start it again.") for job in waiting))

    async def _leave(self, job: Job, message: str) -> None:
        work = self._works.get(job.id)
        if work is None or not job.waits_or_runs:
            return
        job.message = message
        self._leaving.add(job.id)
        process = self._processes.get(job.id)
        if process is not None:
            await process.end()
        elif job.state == "queued":
            self._finish(job, "cancelled")
            return
        await asyncio.wait([work])

    async def _work(self, job: Job) -> None:
        """Run a job when it is its turn."""
        async with self._turn:
            if not job.waits_or_runs:
                return
            try:
                job.state = "running"
                await self._run_steps(job)
            except Exception:
                # A bug of the studio must not leave a job that seems to run for ever.
                logger.exception("job %s", job.id)
                job.message = "The studio failed; its own output says why."
                self._finish(job, "failed")

    async def _run_steps(self, job: Job) -> None:
        for step, arguments in job.request.commands(self.workspace.folder, job.folder).items():
            if job.id in self._leaving:
                self._finish(job, "cancelled")
                return
            job.step, job.stages, job.note = step, {}, ""
            job.save()
            self._changed()
            status = await self._run_command(job, arguments)
            if job.id in self._leaving or status != 0:
                job.remove_step()
            if job.id in self._leaving:
                self._finish(job, "cancelled")
                return
            if status != 0:
                job.message = self._sentences(job)
                self._finish(job, "failed")
                return
        self._finish(job, "done")

    async def _run_command(self, job: Job, arguments: list[str]) -> int:
        """Run one command of a job; returns its exit status."""

        def tell(stage: str, share: float, note: str) -> None:
            if stage == FINISHED:
                return
            if stage not in job.stages:
                # A stage may end before it has done all that it might: the next one's beginning says so.
                job.stages = {**dict.fromkeys(job.stages, 1.0), stage: share}
            job.stages[stage], job.note = share, note
            self._changed()

        process, reading = await StepProcess.start(
            command_line(arguments), job.folder / LOG_FILE, job.folder / PROGRESS_FILE, tell
        )
        self._processes[job.id] = process
        try:
            if job.id in self._leaving:
                await process.end()
            status = await process.wait()
            await reading
            return status
        finally:
            del self._processes[job.id]

    def _sentences(self, job: Job) -> str:
        """Return what a command that failed said."""
        lines = job.log_tail(50).splitlines()
        said = [line.removeprefix(ERROR_MARK) for line in lines if line.startswith(ERROR_MARK)]
        return self.workspace.plain("\n".join(said)) or "The command failed; the log below says where."

    def _finish(self, job: Job, state: str) -> None:
        job.state = state  # pyright: ignore[reportAttributeAccessIssue]  # one of the states
        job.save()
        self._changed()

    def _changed(self) -> None:
        self.version += 1
