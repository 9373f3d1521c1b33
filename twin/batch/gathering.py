"""Evaluations that films ask for at the same time, gathered into one launch."""

from collections import defaultdict, deque
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass
from threading import Lock, Semaphore

from twin.film import Film
from twin.shell import Loads
from twin.shell.device import open_device
from twin.shell.home import World
from twin.shell.worlds import Evaluation, State, Want, Worlds


@dataclass(frozen=True, kw_only=True, eq=False)
class _Request:
    worlds: Worlds
    number: int
    want: Want
    state: State
    answer: "Future[Evaluation]"


class Gathering:
    """Gives a world to each film of a batch and answers what their threads ask.

    Whoever asks and finds the device free serves all who wait, those of the same mesh that want the same in one
    launch. So nobody waits for films that are still solving, and the busier the device, the more films share a launch.
    """

    def __init__(self, *, lanes: int, servers: int) -> None:
        """Prepare for films in lanes numbered from 0 to `lanes` - 1, each with one film at a time.

        Args:
            lanes: number of films at a time.
            servers: number of launches at a time: 1 for a GPU, one a core for the CPU, where a launch uses one.
        """
        self._lanes = lanes
        self._worlds: dict[tuple, Worlds] = {}
        self._waiting: deque[_Request] = deque()
        self._opening = Lock()
        self._serving = Semaphore(servers)

    def world(self, lane: int, film: Film, loads: Loads, device: str) -> World:
        """Return the world of a lane among those of the film's mesh."""
        mesh = film.flat_mm.tobytes(), film.triangles.tobytes(), len(film.contraction)
        key = (*mesh, loads.plate_per_mm, loads.plate_reach_mm, device)
        with self._opening:
            if key not in self._worlds:
                place = open_device(device)
                self._worlds[key] = Worlds(film, loads=loads, device=place, count=self._lanes, threads=1)
            worlds = self._worlds[key]

        def ask(want: Want, state: State) -> Evaluation:
            request = _Request(worlds=worlds, number=lane, want=want, state=state, answer=Future())
            self._waiting.append(request)
            with self._serving:
                if not request.answer.done():
                    self._serve()
            return request.answer.result()

        return World(device=worlds.device, pattern=worlds.pattern, evaluate=ask, response=lambda: worlds.response(lane))

    def _serve(self) -> None:
        """Answer all who wait and are not being served; they want different worlds, one a lane."""
        groups: dict[tuple[Worlds, Want], list[_Request]] = defaultdict(list)
        with suppress(IndexError):  # another thread may take the last one
            while True:
                request = self._waiting.popleft()
                groups[request.worlds, request.want].append(request)
        for (worlds, want), requests in groups.items():
            try:
                found = worlds.evaluate(want, {request.number: request.state for request in requests})
            except Exception as error:
                for request in requests:
                    request.answer.set_exception(error)
            else:
                for request in requests:
                    request.answer.set_result(found[request.number])
