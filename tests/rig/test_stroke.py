"""What is written down of one pass: the loads that were counted along it."""

from typing import cast

import pytest

from planner.program import Pass
from rig.devices import PostLoad, Sighting
from rig.executor.stroke import Stroke


class Told:
    """A load that is what it was told last."""

    def __init__(self, load_g: float) -> None:
        self.now_g = load_g
        self.fed = 0

    def load_g(self) -> float:
        return self.now_g

    def set_load(self, load_g: float) -> None:
        self.now_g = load_g

    def keep_alive(self) -> None:
        self.fed += 1


@pytest.mark.parametrize("seen_mm", [(0.0, 5.0, 15.0, 25.0, 30.0), (0.0, 25.0, 30.0)])
def test_loads_belong_to_the_points_that_they_were_planned_for(seen_mm: tuple[float, ...]) -> None:
    """Whether the stage is seen in every segment or one is missed."""
    points = ((0.0, 0.0), (10.0, 0.0), (20.0, 0.0), (30.0, 0.0))
    planned = Pass(points_mm=points, speed_mm_s=(1.0,), load_g=(1.0, 2.0, 3.0, 4.0), side="convex")
    load = Told(1.0)
    stroke = Stroke(planned, cast(PostLoad, load), None)
    for x in seen_mm:
        stroke(Sighting(position_mm=(x, 0.0, 0.0), held=False))
    made, _ = stroke.done(30.0, 30.0)
    assert made.load_g == planned.load_g
    assert load.fed == len(seen_mm)
