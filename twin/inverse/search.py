"""Clock, history and progress of one inverse design."""

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from twin.inverse.refine import Design

logger = logging.getLogger(__name__)

STEPS = {"coarse": 10, "middle": 7, "passes": 9, "finish": 6}
"""Steps at most in each stage, in `coarse` for each weight of the anchor."""
ROUNDS = {"coarse": 6, "middle": 2, "passes": 2, "finish": 1}
EVALUATIONS = {"coarse": 50, "middle": 25, "passes": 25, "finish": 25}
"""Rounds of hardening in each stage of a robust design, and equilibria in each of them."""
BUDGET_SHARES = {"coarse": 0.25, "middle": 0.4, "passes": 0.65, "finish": 0.85, "limits": 1.0}
"""Share of the budget after which each stage ends: lines and check take the rest."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Moment:
    """A point on the way: what the design scores and what it looks like."""

    elapsed_s: float
    stage: str
    ssim: float
    """Eq. 4 of the designed shape, which the ramp from flat may miss until a stage has ended."""
    rms_mm: float
    top_mm: np.ndarray
    """Top face in the target's frame [mm], shape [n, 3]."""
    triangles: np.ndarray


class Search:
    """Records each design and says whether there is time for another."""

    def __init__(
        self,
        budget_s: float | None,
        progress: Callable[[str, float], None] | None,
        watch: Callable[[Moment], None] | None,
    ) -> None:
        """Start the clock.

        Args:
            budget_s: time to stop after [s], about; None for no limit.
            progress: called with the stage's name and the share done, 0 to 1.
            watch: called with each moment.
        """
        self._started, self._budget_s = time.perf_counter(), budget_s
        self._progress, self._watch = progress, watch
        self.history: list[Moment] = []

    def report(self, stage: str, share: float) -> None:
        """Tell how far a stage is."""
        if self._progress is not None:
            self._progress(stage, share)

    def time_for(self, stage: str) -> bool:
        """Return whether a stage would end before its share of the budget is used up."""
        return time.perf_counter() - self._started < BUDGET_SHARES[stage] * (self._budget_s or float("inf"))

    def watcher(self, stage: str, triangles: np.ndarray) -> Callable[[Design], bool]:
        """Return a function that records designs of a stage on a mesh; it returns whether there is time for more."""
        first = len(self.history)

        def go_on(design: Design) -> bool:
            measured = design.shape.measured
            moment = Moment(
                elapsed_s=time.perf_counter() - self._started,
                stage=stage,
                ssim=measured.ssim,
                rms_mm=measured.rms_mm,
                top_mm=measured.transform.apply(design.shape.top_mm),
                triangles=triangles,
            )
            logger.info("%s %.1f s: ssim %.4f, rms %.3f mm", stage, moment.elapsed_s, moment.ssim, moment.rms_mm)
            self.history.append(moment)
            self.report(stage, min(1.0, (len(self.history) - first) / (2 * STEPS[stage])))
            if self._watch is not None:
                self._watch(moment)
            return self._budget_s is None or moment.elapsed_s < BUDGET_SHARES[stage] * self._budget_s

        return go_on
