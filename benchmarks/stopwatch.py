"""Add up wall time by name, also of methods deep inside a run."""

import functools
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest.mock import patch


class Stopwatch:
    """Wall time [s] and number of calls under each name, in the order of first use."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.calls: dict[str, int] = {}

    @contextmanager
    def measure(self, name: str) -> Iterator[None]:
        started = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - started
            self.calls[name] = self.calls.get(name, 0) + 1

    @contextmanager
    def measure_methods(self, name: str, owner: type, *methods: str) -> Iterator[None]:
        """Measure all calls of some methods of a class; they must not call one another."""

        def measured(method: Callable[..., Any]) -> Callable[..., Any]:
            @functools.wraps(method)
            def call(*arguments: Any, **named: Any) -> Any:
                with self.measure(name):
                    return method(*arguments, **named)

            return call

        with ExitStack() as stack:
            for method in methods:
                stack.enter_context(patch.object(owner, method, measured(getattr(owner, method))))
            yield


class StageClock:
    """A progress callback that gives each stage the time until the next one is reported."""

    def __init__(self, stopwatch: Stopwatch, *, prefix: str) -> None:
        self._stopwatch, self._prefix = stopwatch, prefix
        self._running, self._since = "", 0.0

    def __call__(self, stage: str, share: float) -> None:
        now = time.perf_counter()
        if self._running:
            name = f"{self._prefix}{self._running}"
            seconds = self._stopwatch.seconds
            seconds[name] = seconds.get(name, 0.0) + now - self._since
        self._running, self._since = "" if share >= 1.0 else stage, now
