"""One command of a job as a process of its own: its progress, its log, its end."""

import asyncio
import json
import os
import signal
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from scenes.progress import LINES_VARIABLE

ENDINGS = ((signal.SIGINT, 4.0), (signal.SIGTERM, 2.0), (signal.SIGKILL, 10.0))
"""How a process is ended, politely first, and how long to wait before the next [s]."""


class StepProcess:
    """A running command in a process group of its own, so that all of it can be ended."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self._process = process

    @classmethod
    async def start(
        cls, arguments: list[str], log: Path, progress: Path, tell: Callable[[str, float, str], None]
    ) -> tuple["StepProcess", asyncio.Task[None]]:
        """Start a command; returns it and the task that reads its progress until it ends.

        Args:
            arguments: of the process, the executable first.
            log: file that its output is added to.
            progress: file that its lines of progress are added to.
            tell: called with a stage, the share done and a note.
        """
        reading, writing = os.pipe()
        try:
            with log.open("ab") as output:
                process = await asyncio.create_subprocess_exec(
                    *arguments,
                    stdin=asyncio.subprocess.DEVNULL,
                    stdout=output,
                    stderr=output,
                    env={**os.environ, LINES_VARIABLE: str(writing), "PYTHONUNBUFFERED": "1"},
                    pass_fds=(writing,),
                    start_new_session=True,
                )
        except BaseException:
            os.close(reading)
            raise
        finally:
            os.close(writing)
        return cls(process), asyncio.create_task(_read(reading, progress, tell))

    async def wait(self) -> int:
        """Wait for its end; returns the exit status."""
        return await self._process.wait()

    async def end(self) -> None:
        """End it and all that it started."""
        for sign, patience_s in ENDINGS:
            self._signal(sign)
            with suppress(TimeoutError):
                await asyncio.wait_for(self._process.wait(), patience_s)
                break
        self._signal(signal.SIGKILL)

    def _signal(self, sign: signal.Signals) -> None:
        """Send a signal to the group, which may be gone."""
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, sign)


async def _read(descriptor: int, path: Path, tell: Callable[[str, float, str], None]) -> None:
    """Pass lines of progress on until the last writer has closed."""
    reader = asyncio.StreamReader()
    loop = asyncio.get_running_loop()
    transport, _ = await loop.connect_read_pipe(
        lambda: asyncio.StreamReaderProtocol(reader), os.fdopen(descriptor, "rb", buffering=0)
    )
    try:
        with path.open("ab") as kept:
            async for line in reader:
                kept.write(line)
                step = json.loads(line)
                tell(step["stage"], step["share"], step["note"])
    finally:
        transport.close()
