"""Work on many films at the same time: a thread for each, their evaluations gathered."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from queue import SimpleQueue
from typing import TypeVar

from planner.errors import InputError
from twin.batch.gathering import Gathering
from twin.equilibrium.linear import solve_on_one_core
from twin.film import Film
from twin.shell import Loads
from twin.shell.device import open_device
from twin.shell.home import World, living_in

LANES_ON_GPU = 32
"""Films at a time on a GPU: enough to fill it; their factorisations take the cores in turn."""

T = TypeVar("T")


def run_together(
    jobs: Sequence[Callable[[], T]],
    *,
    device: str = "auto",
    lanes: int | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> list[T]:
    """Run jobs that each simulate a film, side by side; return what they return, in their order.

    Every `Shell` that a job makes is evaluated in launches shared with the other jobs, and every solver works on one
    core. A job need not know: it may be any function that finds equilibria, and its result does not depend on the
    others. Pays for jobs of one mesh; another mesh takes arrays of its own.

    Args:
        jobs: functions without arguments.
        device: device that their kernels run on.
        lanes: jobs at a time; None for one a core, and `LANES_ON_GPU` on a GPU. Memory grows with it.
        progress: called with the stage's name and the share of the jobs done, 0 to 1.

    Raises:
        InputError: if `lanes` is not positive or the device is unknown.
        Exception: the first that a job raises; those not yet begun are dropped.
    """
    if lanes is not None and lanes < 1:
        raise InputError(f"lanes: found {lanes}, allowed are whole numbers from 1; leave it out for one a core.")
    cores, cuda = os.cpu_count() or 1, open_device(device).is_cuda
    lanes = min(lanes or (LANES_ON_GPU if cuda else cores), max(len(jobs), 1))
    gathering = Gathering(lanes=lanes, servers=1 if cuda else cores)
    free: SimpleQueue[int] = SimpleQueue()
    for lane in range(lanes):
        free.put(lane)

    def run(job: Callable[[], T]) -> T:
        lane = free.get()

        def home(film: Film, loads: Loads, device: str, threads: int | None) -> World:
            return gathering.world(lane, film, loads, device)

        try:
            with living_in(home):
                return job()
        finally:
            free.put(lane)

    with ThreadPoolExecutor(lanes, initializer=solve_on_one_core) as pool:
        running = [pool.submit(run, job) for job in jobs]
        try:
            for done, future in enumerate(as_completed(running), start=1):
                future.result()
                if progress is not None:
                    progress("films", done / len(jobs))
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return [future.result() for future in running]
