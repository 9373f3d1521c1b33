"""Progress of long work: a bar on a terminal, lines for the program that asks for them, nothing in a pipe."""

import json
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

LINES_VARIABLE = "LCE_PROGRESS_FD"
"""Environment variable with the number of an open file to write progress into, one JSON object a line."""
LEAST_PAUSE_S = 0.1
"""Between two lines of one stage: who reads them shows them to a person."""


class ProgressSink(Protocol):
    """Where progress is told."""

    def __call__(self, stage: str, share: float) -> None:
        """Tell the share of a stage that is done, 0 to 1."""
        ...

    def note(self, stage: str, text: str) -> None:
        """Tell a few words about a stage."""
        ...


class Lines:
    """One line of JSON for each step: {"stage": ..., "share": ..., "note": ...}."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._stage, self._note = "", ""
        self._share, self._not_before = 0.0, 0.0

    def __call__(self, stage: str, share: float) -> None:
        """Write the share of a stage that is done, unless the stage's last line is too fresh."""
        begins = stage != self._stage
        if begins:
            self._stage, self._note = stage, ""
        self._share = share
        if begins or share >= 1.0 or time.monotonic() >= self._not_before:
            self._write()

    def note(self, stage: str, text: str) -> None:
        """Write a few words about a stage with its next line."""
        if stage == self._stage:
            self._note = text
        else:
            self(stage, 0.0)
            self._note = text

    def _write(self) -> None:
        line = {"stage": self._stage, "share": round(self._share, 4), "note": self._note}
        try:
            os.write(self._descriptor, (json.dumps(line) + "\n").encode())
        except BrokenPipeError:
            # Who asked for this work has gone: nobody will fetch its result.
            raise KeyboardInterrupt from None
        self._not_before = time.monotonic() + LEAST_PAUSE_S


class Bars:
    """One bar for each stage, full when the next begins."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._tasks: dict[str, TaskID] = {}

    def __call__(self, stage: str, share: float) -> None:
        """Draw the share of a stage that is done, 0 to 1."""
        self._progress.update(self._task(stage), completed=share)

    def note(self, stage: str, text: str) -> None:
        """Write a few words behind a stage's bar."""
        self._progress.update(self._task(stage), note=text)

    def _task(self, stage: str) -> TaskID:
        if stage not in self._tasks:
            for begun in self._tasks.values():
                # A stage may end before it has done all that it might: the next one's beginning says so.
                self._progress.update(begun, completed=1.0)
            self._tasks[stage] = self._progress.add_task(stage, total=1.0, note="")
        return self._tasks[stage]


@contextmanager
def progress_bar() -> Iterator[ProgressSink]:
    """Yield the bars, drawn on stderr if it is a terminal, or the lines, where another program asks for them.

    Raises:
        KeyboardInterrupt: as soon as that program is gone.
    """
    asked = os.environ.get(LINES_VARIABLE, "")
    if asked.isdigit():
        yield Lines(int(asked))
        return
    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description:<12}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("{task.fields[note]}"),
    )
    with Progress(*columns, console=console, disable=not console.is_terminal) as bars:
        yield Bars(bars)
