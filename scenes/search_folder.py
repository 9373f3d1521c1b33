"""The folder beside the results in which an inverse design shows how far it is, and from which it can go on."""

import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from planner.errors import InputError
from planner.target import Target
from scenes.checkpoint import save_checkpoint
from scenes.pictures import CurrentPicture
from twin.inverse import Field, Moment

CHECKPOINT_FILE, CURRENT_FILE = "checkpoint.npz", "current.png"
LEAST_PAUSE_S = 2.0
PAUSE_PER_DRAWING = 10.0
"""Pause after a picture over the time that it took: pictures cost at most a tenth of a search."""


def search_folder(out: Path) -> Path:
    """Return the folder that belongs to a folder of results: `<out>.progress` beside it."""
    out = out.resolve()
    return out.with_name(f"{out.name}.progress")


class SearchFolder:
    """Writes the present shape and the fields to go on from, each file whole or not at all."""

    def __init__(self, folder: Path, target: Target, inputs: str) -> None:
        """Prepare.

        Args:
            folder: where to write.
            target: drawn beside the shape.
            inputs: digest that the fields belong to.
        """
        self._folder, self._target, self._inputs = folder, target, inputs
        self._picture: CurrentPicture | None = None
        self._not_before = 0.0

    def watch(self, moment: Moment) -> None:
        """Draw a design if the last picture is old enough."""
        if time.perf_counter() < self._not_before:
            return
        self._picture = self._picture or CurrentPicture(self._target)
        started = time.perf_counter()
        self._picture.draw(
            self._folder / CURRENT_FILE,
            moment.top_mm,
            moment.triangles,
            caption=f"{moment.stage}, {moment.elapsed_s:.0f} s: SSIM {moment.ssim:.3f}, RMS {moment.rms_mm:.2f} mm",
        )
        ended = time.perf_counter()
        self._not_before = ended + max(LEAST_PAUSE_S, PAUSE_PER_DRAWING * (ended - started))

    def keep(self, field: Field) -> None:
        """Save the fields of a stage."""
        save_checkpoint(self._folder / CHECKPOINT_FILE, field, self._inputs)

    def remove(self) -> None:
        """Remove the files, and the folder unless the user keeps others in it."""
        for name in (CHECKPOINT_FILE, CURRENT_FILE):
            (self._folder / name).unlink(missing_ok=True)
        with suppress(OSError):
            self._folder.rmdir()


@contextmanager
def opened_search_folder(out: Path, target: Target, inputs: str) -> Iterator[SearchFolder]:
    """Yield the writer into a search's folder; after an error it stays if there is something to go on from.

    Raises:
        InputError: if the folder cannot be made.
    """
    folder = search_folder(out)
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(
            f"--out: cannot make {folder} for the progress ({error.strerror}); name a folder beside which it can be "
            "made."
        ) from error
    searching = SearchFolder(folder, target, inputs)
    try:
        yield searching
    except BaseException:
        if not (folder / CHECKPOINT_FILE).exists():
            searching.remove()
        raise
