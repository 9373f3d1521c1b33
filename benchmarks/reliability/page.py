"""The page docs/reliability.md."""

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.reliability.scene import Ended
from rig.executor.operations import Operation

HEAD = """# What a run survives

Made by `python -m benchmarks.reliability`; do not edit. {faults} faults, each injected at each of the {stages}
operations of a small run on the simulated machine ({operations}): {runs} runs. **{positions} silent wrong
positions, light, ink or heat, {doses} wrong or doubled doses,
{twice} operations done twice, {missing} missing, {hung} hangs, {unfinished} that could not be finished.**

How it is checked: whenever the run takes an operation for done, the virtual machine is asked where its axes
really are (in steps, not as its controller believes), where its post touched the film since the operation
began, how much water its plunger really moved, how much ink flowed, how long the lamp shone, how warm air and
plate became, and whether all of them are off. A session that fails says why, the cause is put right (cable
plugged in, disk freed), and the run is resumed with an operator who says yes, until it is finished; then the
as-run log must have each operation exactly once as ended. That the check itself can fail is tested in
tests/rig/test_reliability.py.

- *went through*: the fault did no harm, or the drivers put it right (repeated questions, counters read again).
- *told*: the session ended with a sentence that says what and what to do; the resumed run finished.
- *sessions*: the most that one run needed.

| fault | runs | went through | told, resumed | sessions | silent failures | hangs |
|---|---|---|---|---|---|---|
"""

TAIL = """

What this does not show: lost steps. A stage without encoders that is held back by force believes that it moved;
the audit compares with what the controller counts, and only homing finds such a loss. A pump's counters see the
plunger, not the water: air, a leak or friction of the post is what the calibration on a balance and the first
strip are for. A stop over these lines is no emergency stop.

`kill -9`: `pytest -m slow tests/rig/test_kill.py` kills a run 200 times at random instants, a real process with
a real signal, and resumes it each time: see [decisions/0011-rig-run.md](decisions/0011-rig-run.md).
"""


@dataclass(frozen=True, kw_only=True)
class Row:
    """One fault at all stages."""

    name: str
    ends: tuple[Ended, ...]


def reliability_page(rows: Sequence[Row], operations: Sequence[Operation]) -> str:
    """Return the page as Markdown."""
    ends = [end for row in rows for end in row.ends]
    wrong = [text for end in ends for text in end.wrong]
    doses = sum("mL" in text for text in wrong)
    kinds = dict.fromkeys(operation.kind for operation in operations)
    head = HEAD.format(
        faults=len(rows),
        stages=len(operations),
        operations=", ".join(kind.replace("_", " ") for kind in kinds),
        runs=len(ends),
        positions=len(wrong) - doses,
        doses=doses,
        twice=sum(len(end.twice) for end in ends),
        missing=sum(len(end.missing) for end in ends),
        hung=sum(end.hung for end in ends),
        unfinished=sum(not end.finished for end in ends),
    )
    return head + "".join(_line(row) for row in rows) + TAIL


def _line(row: Row) -> str:
    through = sum(end.finished and not end.told for end in row.ends)
    told = sum(end.finished and bool(end.told) for end in row.ends)
    cells = (
        row.name,
        len(row.ends),
        through,
        told,
        1 + max(len(end.told) for end in row.ends),
        sum(len(end.wrong) + len(end.twice) + len(end.missing) for end in row.ends),
        sum(end.hung for end in row.ends),
    )
    return f"| {' | '.join(map(str, cells))} |\n"
