"""A virtual balance on a wire: MT-SICS around a pan that needs time to rest.

What it shows follows the load with a lag, and `S` and `Z` wait until that has changed by less than a step for a while.
Source: Mettler-Toledo, MT-SICS reference manual 11780711.
"""

from collections import deque
from collections.abc import Callable
from math import exp, inf
from typing import Final

from numpy.random import Generator

from rig.virtual.answering import ANSWER_S, LineInbox, Outbox

TICK_S: Final = 0.1
RESTS_FOR: Final = 6
"""Ticks without a change, after which the pan rests."""
GIVES_UP_S: Final = 30.0
FORGETS_S: Final = 60.0
"""Time after which what the pan did before does not matter [s]."""


class VirtualBalance:
    """Such a balance. Public attributes are settings and faults, open to tests.

    Args:
        load_g: weight on the pan at a time [g].
        generator: source of the noise.
    """

    def __init__(self, load_g: Callable[[float], float], generator: Generator) -> None:
        self.step_g = 0.001
        self.capacity_g = 220.0
        self.noise_g = 0.0005
        """Standard deviation of what is shown [g]."""
        self.lag_s = 0.4
        self.shakes_g = 0.0
        """Fault: the table shakes the pan to and fro by so much [g]."""
        self._load_g = load_g
        self._generator = generator
        self._inbox = LineInbox()
        self._outbox = Outbox()
        self._waiting: tuple[str, float] | None = None
        self._now_s = 0.0
        self._pan_g = load_g(0.0)
        self._zero_g = 0.0
        self._before: deque[float] = deque(maxlen=RESTS_FOR)
        self._odd = False

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that arrive at a time [s]."""
        self._advance(now_s)
        for line in self._inbox.take(data):
            match line:
                case "S" | "Z":
                    self._waiting = (line, now_s + GIVES_UP_S)
                case "SI":
                    self._say(f"S {'S' if self._rests() else 'D'} {self._shown()}", now_s)
                case "I4" | "@":
                    self._say('I4 A "B021002593"', now_s)
                    self._waiting = None
                case _:
                    self._say("ES", now_s)

    def send(self, now_s: float) -> bytes:
        """Return the bytes sent up to a time [s], each once."""
        self._advance(now_s)
        return self._outbox.due(now_s)

    def next_event_s(self, now_s: float) -> float:
        """Return the next time [s] at which the balance does or sends something by itself; infinite if never."""
        self._advance(now_s)
        return min(self._outbox.next_s(), inf if self._waiting is None else self._now_s + TICK_S)

    def _advance(self, now_s: float) -> None:
        if now_s - self._now_s > FORGETS_S and self._waiting is None:
            self._now_s = now_s - FORGETS_S
        while self._now_s + TICK_S <= now_s:
            self._now_s += TICK_S
            self._odd = not self._odd
            load_g = self._load_g(self._now_s) + (self.shakes_g if self._odd else -self.shakes_g)
            self._pan_g = load_g + (self._pan_g - load_g) * exp(-TICK_S / self.lag_s)
            self._before.append(self._pan_g)
            self._answer_waiting()

    def _rests(self) -> bool:
        return len(self._before) == RESTS_FOR and max(self._before) - min(self._before) < self.step_g

    def _answer_waiting(self) -> None:
        if self._waiting is None:
            return
        (command, until_s), net_g = self._waiting, self._pan_g - self._zero_g
        outside = "+" if net_g > self.capacity_g else "-" if net_g < -self.capacity_g / 10 else None
        if outside is not None:
            answer = f"{command} {outside}"
        elif self._rests():
            answer = "Z A" if command == "Z" else f"S S {self._shown()}"
            self._zero_g = self._pan_g if command == "Z" else self._zero_g
        elif self._now_s >= until_s:
            answer = f"{command} I"
        else:
            return
        self._waiting = None
        self._say(answer, self._now_s)

    def _shown(self) -> str:
        net_g = self._pan_g - self._zero_g + self.noise_g * self._generator.standard_normal()
        return f"{round(net_g / self.step_g) * self.step_g:10.3f} g"

    def _say(self, text: str, now_s: float) -> None:
        self._outbox.put(f"{text}\r\n".encode("ascii"), now_s + ANSWER_S)
