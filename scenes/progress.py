"""Progress of long work: a bar on a terminal, nothing in a pipe."""

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn


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
def progress_bar() -> Iterator[Bars]:
    """Yield the bars, drawn on stderr if it is a terminal."""
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
