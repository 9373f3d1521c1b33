"""The as-run log: what was really done to a film, in the Program's words; one JSON object a line."""

from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from planner.program.machine import Machine
from planner.program.operations import Pass, Strict
from planner.program.program import Program

AS_RUN_FILE = "as-run.jsonl"

Kind = Literal["deposit", "reset_alignment", "load", "pass", "cure", "cut", "actuate"]
Outcome = Literal["done", "spoiled", "left", "interrupted", "failed"]
"""`spoiled`: done, but disturbed; `left`: cut off and left so by the operator; both others were not verified."""
ENDED: tuple[Outcome, ...] = ("done", "spoiled", "left")
"""Outcomes after which an operation is not done again."""


class AsRunProgram(Strict):
    """First line of a log: the Program as it was planned."""

    record: Literal["program"] = "program"
    program: Program
    digest: str


class AsRunSession(Strict):
    """Beginning of a session: a run has several if it was cut off and resumed."""

    record: Literal["session"] = "session"
    number: Annotated[int, Field(ge=1)]
    at_s: float
    """Time since the run began [s]."""
    started_utc: str
    software: str
    machine: Machine
    rig_digest: str
    simulated: bool
    attended: tuple[str, ...]
    """Devices that an operator works."""
    devices: dict[str, str]
    """What each device says that it is."""


class AsRunOperation(Strict):
    """One attempt at one operation of the run."""

    record: Literal["operation"] = "operation"
    number: Annotated[int, Field(ge=0)]
    kind: Kind
    layer: int | None
    """0 is the bottom layer; None for what is done to the whole film."""
    pass_number: int | None = None
    """Place among the layer's passes, as planned."""
    attempt: Annotated[int, Field(ge=1)]
    outcome: Outcome
    start_s: float
    """Time since the run began [s]."""
    end_s: float
    stroke: Pass | None = None
    """The pass with the loads that the pump counted and the speeds that were measured; as far as it got."""
    post_load_g: tuple[float, ...] | None = None
    """What the post really pressed with, one value or one for each point, where something measures it [g]."""
    load_g: float | None = None
    """Load by the pump's counters after the operation [g]."""
    weighed_load_g: float | None = None
    """Load by the balance, where it was weighed [g]."""
    position_mm: tuple[float, float, float] | None = None
    """Where the stage was after the operation, verified against the plan [mm]."""
    temperature_c: float | None = None
    """Temperature that was measured on average while it was held, or that an operator confirmed [C]."""
    deposited_ml: float | None = None
    """Ink by the time for which the extruder's valve was open [mL]."""
    note: str = ""


class AsRunAnswer(Strict):
    """A question to the operator and what was answered."""

    record: Literal["answer"] = "answer"
    at_s: float
    question: str
    yes: bool
    by: str
    """Who or what answered."""


class AsRunNote(Strict):
    """Something that happened beside the operations."""

    record: Literal["note"] = "note"
    at_s: float
    text: str


class AsRunEnd(Strict):
    """End of a session."""

    record: Literal["end"] = "end"
    at_s: float
    outcome: Literal["finished", "paused", "stopped", "failed"]
    message: str = ""


AsRunRecord = Annotated[
    AsRunProgram | AsRunSession | AsRunOperation | AsRunAnswer | AsRunNote | AsRunEnd, Field(discriminator="record")
]
RECORD: TypeAdapter[AsRunRecord] = TypeAdapter(AsRunRecord)
