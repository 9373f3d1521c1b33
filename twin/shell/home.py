"""Where a shell's evaluations take place: on arrays of its own, or beside other films in a batch."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

import numpy as np
import warp as wp

from twin.film.film import Film
from twin.shell.device import open_device
from twin.shell.loads import Loads
from twin.shell.topology import Pattern
from twin.shell.worlds import Evaluation, State, Want, Worlds


@dataclass(frozen=True, kw_only=True, eq=False)
class World:
    """What a shell needs of the place where it is evaluated."""

    device: wp.Device
    pattern: Pattern
    evaluate: Callable[[Want, State], Evaluation]
    response: Callable[[], tuple[np.ndarray, np.ndarray]]
    """Stress and strain derivatives of the last evaluation, see `Worlds.response`."""


def own_world(film: Film, loads: Loads, device: str, threads: int | None) -> World:
    """Return a world with arrays of its own."""
    worlds = Worlds(film, loads=loads, device=open_device(device), threads=threads)
    return World(
        device=worlds.device,
        pattern=worlds.pattern,
        evaluate=lambda want, state: worlds.evaluate(want, {0: state})[0],
        response=lambda: worlds.response(0),
    )


HomeOf = Callable[[Film, Loads, str, int | None], World]
_home: ContextVar[HomeOf] = ContextVar("home", default=own_world)


def world_for(film: Film, *, loads: Loads, device: str, threads: int | None) -> World:
    """Return the world of a new shell, given by the innermost `living_in` around it."""
    return _home.get()(film, loads, device, threads)


@contextmanager
def living_in(home: HomeOf) -> Iterator[None]:
    """Let `home` give a world to each shell that this thread makes meanwhile."""
    token = _home.set(home)
    try:
        yield
    finally:
        _home.reset(token)
