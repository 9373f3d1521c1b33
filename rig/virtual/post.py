"""What the post really presses with: the water in its chamber, less friction, a little later, with noise.

    G = play(W, h)          dry friction in the guide: the post follows the water's weight W only once that differs
                            by h, so that loading and unloading differ by 2 h (the play, or backlash, operator)
    tau dF/dt = G - F       the post and the film give way slowly
    F + n                   n: noise of standard deviation sigma that forgets itself in a time (Ornstein-Uhlenbeck)

Source of the play operator: Visintin, Differential Models of Hysteresis, 1994, chapter III.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import exp, sqrt

from numpy.random import Generator


@dataclass(frozen=True, kw_only=True)
class PostQuality:
    """How well a post is made; by default well."""

    friction_g: float = 0.01
    """Half the difference between loading and unloading [g]."""
    lag_s: float = 0.2
    noise_g: float = 0.01
    """Standard deviation [g]."""
    noise_time_s: float = 0.1
    """Time in which the noise forgets itself [s]."""


class VirtualPost:
    """Post under a chamber; times asked for never go back.

    Args:
        water_g: weight of the water in the chamber at a time [g].
        generator: source of the noise.
        quality: friction, lag and noise.
    """

    def __init__(
        self, water_g: Callable[[float], float], generator: Generator, *, quality: PostQuality | None = None
    ) -> None:
        self._water_g = water_g
        self._generator = generator
        self._quality = PostQuality() if quality is None else quality
        self._now_s = 0.0
        self._pressing_g = self._settled_g = water_g(0.0)
        self._noise_g = self._quality.noise_g * generator.standard_normal()

    def force_g(self, now_s: float) -> float:
        """Return the force on the film at a time [g]; a post cannot pull, so that it is never below 0."""
        quality, passed_s = self._quality, now_s - self._now_s
        water_g = self._water_g(now_s)
        self._pressing_g = min(max(self._pressing_g, water_g - quality.friction_g), water_g + quality.friction_g)
        if passed_s > 0:
            left = exp(-passed_s / quality.lag_s) if quality.lag_s else 0.0
            self._settled_g = self._pressing_g + (self._settled_g - self._pressing_g) * left
            kept = exp(-passed_s / quality.noise_time_s)
            self._noise_g *= kept
            self._noise_g += quality.noise_g * sqrt(1 - kept * kept) * self._generator.standard_normal()
            self._now_s = now_s
        return max(0.0, self._settled_g + self._noise_g)

    def resting_g(self, now_s: float) -> float:
        """Return the force of a post that stands still at a time [g]: the noise is that of scratching."""
        self.force_g(now_s)
        return max(0.0, self._settled_g)

    def mean_force_g(self, since_s: float, until_s: float, *, every_s: float = 0.05) -> float:
        """Return the force on the film between two times on average [g], from looks at a distance [s]."""
        count = max(1, round((until_s - since_s) / every_s))
        looks = [self.force_g(since_s + (until_s - since_s) * look / count) for look in range(count + 1)]
        return sum(looks) / len(looks)
