"""What is seen of a run on a terminal: layer, pass, position, load, temperature and time left; nothing in a pipe."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from rich.console import Console, Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table

from rig.executor.view import Moment, View

PAUSING = "Pausing after this operation; Ctrl-C again stops at once."
DRAW_S = 0.1
"""Least time between two drawings [s]: a simulated hour takes seconds."""


class LiveView:
    """Draws the present moment."""

    def __init__(self, live: Live) -> None:
        self._live = live
        self._drawn_s = 0.0

    def begin(self, moment: Moment) -> None:
        """See an operation begin."""
        self.move(moment)

    def move(self, moment: Moment) -> None:
        """See the stage move."""
        if time.monotonic() - self._drawn_s >= DRAW_S:
            self._drawn_s = time.monotonic()
            self._live.update(drawn(moment))

    def clear(self) -> None:
        """Show nothing until the next moment."""
        self._drawn_s = 0.0
        self._live.update("", refresh=True)


class PipedView:
    """Says that a pause was understood, and nothing else."""

    def __init__(self) -> None:
        self._told = False

    def begin(self, moment: Moment) -> None:
        """See an operation begin."""
        self.move(moment)

    def move(self, moment: Moment) -> None:
        """See the stage move."""
        if moment.pausing and not self._told:
            with suppress(OSError):  # Ctrl-C also ends whatever a pipe goes to, and must not tear the run
                sys.stderr.write(f"{PAUSING}\n")
        self._told = moment.pausing

    def clear(self) -> None:
        """Nothing is shown."""


def drawn(moment: Moment) -> Group:
    """Return a moment as a small table and a bar."""
    operation, position = moment.operation, moment.position_mm
    table = Table.grid(padding=(0, 2))
    rows = [
        ("operation", f"{operation.number + 1} of {moment.count}: {operation.title}"),
        ("position", "not known yet" if position is None else "x {:.2f}  y {:.2f}  z {:.2f} mm".format(*position)),
        ("load", "not known yet" if moment.load_g is None else f"{moment.load_g:.3f} g"),
        ("temperature", "nothing heats" if moment.temperature_c is None else f"{moment.temperature_c:.0f} C"),
        ("time", f"{moment.at_s / 60:.0f} min, about {moment.left_s / 60:.0f} min left"),
    ]
    if moment.pausing:
        rows.append(("asked", PAUSING))
    for row in rows:
        table.add_row(*row)
    return Group(table, ProgressBar(total=moment.count, completed=operation.number, width=60))


@contextmanager
def live_view() -> Iterator[View]:
    """Yield the view, drawn on stderr if it is a terminal."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield PipedView()
        return
    with Live(console=console, refresh_per_second=10, transient=True) as live:
        yield LiveView(live)
