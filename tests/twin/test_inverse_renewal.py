"""A robust design looks for new films that noise makes of it, and keeps the old ones where a new one has no shape."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from planner.errors import SolverError
from twin.inverse.refine import Design, Refinement

SHAPE = SimpleNamespace(vertices_mm=np.zeros((3, 3)), measured=SimpleNamespace(value=0.5))


class Control:
    def q(self, p):
        return p

    def penalty(self, p):
        return 0.0, p


class Anchor:
    def value(self, q):
        return 0.0, q


class Film:
    """Finds its shape unless the errors are too large."""

    def __init__(self):
        self.distortion = None

    def linearise(self, q, shape):
        return True

    def settle(self, q, start_mm, near):
        if self.distortion == "too much":
            raise SolverError("no equilibrium")
        return SHAPE


class Noise:
    def __init__(self, worst):
        self.worst_now = worst

    def worst(self, world, q, shape):
        return self.worst_now


@pytest.mark.parametrize(
    ("worst", "kept"), [(["some", "more"], ["some", "more"]), (["some", "too much"], ["before", "before"])]
)
def test_films_are_renewed_together_or_not_at_all(worst, kept):
    films = [Film() for _ in range(3)]
    for film in films[1:]:
        film.distortion = "before"
    refinement = Refinement(
        cast(Any, films), cast(Any, Control()), cast(Any, Anchor()), weight_per_mm3=1.0, noise=cast(Any, Noise(worst))
    )
    p = np.zeros(2)
    design = Design(p=p, q=p, shapes=cast(Any, (SHAPE,) * 3), value=0.5)
    assert refinement.renewed(design).value == 0.5
    assert [film.distortion for film in films] == [None, *kept]
