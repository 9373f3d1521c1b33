"""What a report is made of."""

from dataclasses import dataclass
from typing import Any

from planner.program import Machine, Program
from planner.target import Target
from twin.hot_shape import HotShape
from twin.score import Scored


@dataclass(frozen=True, kw_only=True, eq=False)
class ReportContents:
    """A prediction with what it was made from; the report says nothing else."""

    result: dict[str, Any]
    """The content of result.json: every number of the report comes from here."""
    program: Program
    """The Program that was predicted, for the playback of its passes."""
    machine: Machine
    """Whose speeds time the passes."""
    shape: HotShape
    """The film at each temperature, for the 3-D view."""
    target: Target | None
    scored: Scored | None
    """How the shape lies over its target; None where there was none."""
    source: str = "PLAN"
    """What was predicted, as the user wrote it: a plan's folder, a Program's file, or a run's; for the commands."""
