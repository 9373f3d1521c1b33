"""What a journal says about a run that was cut off: what is done, what was under way, and the load in the chamber."""

from dataclasses import dataclass, field
from typing import Any

from planner.errors import InputError
from planner.program.as_run import ENDED, RECORD, AsRunOperation, AsRunRecord
from rig.dialects.new_era import Dispensed
from rig.pump_load import AuditedLoad


@dataclass(frozen=True, kw_only=True)
class Begun:
    """An operation that was begun and whose end was never verified."""

    number: int
    attempt: int
    at_s: float
    ended: bool
    """Whether the journal has how it ended, as failed or interrupted; else the run was cut off in it."""


@dataclass(frozen=True, kw_only=True)
class Past:
    """The past of a run; empty for one that begins."""

    ended: frozenset[int] = frozenset()
    attempts: dict[int, int] = field(default_factory=dict)
    begun: Begun | None = None
    spoiled: int | None = None
    """The disturbed stroke of which nobody has decided yet whether it is done again."""
    load: AuditedLoad | None = None
    """What the pump's counters last said; None if they never were read or the load was not known."""
    touched_s: dict[int, float] = field(default_factory=dict)
    """For each layer, when its first pass began [s]."""
    at_s: float = 0.0
    """When the last entry was written, by the run's time [s]."""
    utc_s: float = 0.0
    """The same by the date [s]."""
    sessions: int = 0
    finished: bool = False
    records: tuple[AsRunRecord, ...] = ()


def read_past(entries: list[dict[str, Any]], *, program: str, rig: str, path: str) -> Past:
    """Read a journal's entries.

    Raises:
        InputError: if it is the journal of another Program or another rig.
    """
    ended: set[int] = set()
    attempts: dict[int, int] = {}
    touched: dict[int, float] = {}
    begun: Begun | None = None
    spoiled: int | None = None
    load: AuditedLoad | None = None
    sessions, finished, records = 0, False, []
    for entry in entries:
        _check_digests(entry, program, rig, path)
        match entry["event"]:
            case "session":
                sessions += 1
            case "begin":
                begun = Begun(number=entry["op"], attempt=entry["attempt"], at_s=entry["at_s"], ended=False)
                attempts[begun.number] = begun.attempt
                spoiled = None
                ended.discard(begun.number)  # a disturbed stroke is done again: the new attempt counts
                if entry.get("touches") is not None:
                    touched.setdefault(entry["touches"], entry["at_s"])
            case "end":
                number, verified = entry["op"], entry["record"]["outcome"] in ENDED
                if verified:
                    ended.add(number)
                begun = None if verified else _closed(begun, entry)
                spoiled = number if entry["record"]["outcome"] == "spoiled" else None
            case "kept":
                spoiled = None
            case "closed":
                finished = entry["record"]["outcome"] == "finished"
        if "load" in entry:
            load = load_from(entry["load"])
        if "record" in entry:
            records.append(RECORD.validate_python(entry["record"], strict=False))
    return Past(
        ended=frozenset(ended),
        attempts=attempts,
        begun=begun,
        spoiled=spoiled,
        load=load,
        touched_s=touched,
        at_s=entries[-1]["at_s"] if entries else 0.0,
        utc_s=entries[-1]["utc_s"] if entries else 0.0,
        sessions=sessions,
        finished=finished,
        records=tuple(records),
    )


def _closed(begun: Begun | None, entry: dict[str, Any]) -> Begun:
    record = entry["record"]
    at_s = record["start_s"] if begun is None else begun.at_s
    return Begun(number=entry["op"], attempt=record["attempt"], at_s=at_s, ended=True)


def _check_digests(entry: dict[str, Any], program: str, rig: str, path: str) -> None:
    if entry["event"] != "session":
        return
    for name, found, wanted in (("Program", entry["program"], program), ("rig file", entry["rig"], rig)):
        if found != wanted:
            raise InputError(
                f"{path}: was begun with another {name} ({found[:19]}..., not {wanted[:19]}...); resume with the one "
                "that it was begun with, or begin anew in another folder"
            )


def load_to(load: AuditedLoad | None) -> dict[str, float] | None:
    """Write an audited load as a journal has it."""
    if load is None:
        return None
    counters = load.counters
    return {
        "load_g": load.load_g,
        "infused_ml": counters.infused_ml,
        "withdrawn_ml": counters.withdrawn_ml,
        "resolution_ml": counters.resolution_ml,
    }


def load_from(entry: dict[str, float] | None) -> AuditedLoad | None:
    """Read an audited load as a journal has it."""
    if entry is None:
        return None
    counters = Dispensed(
        infused_ml=entry["infused_ml"], withdrawn_ml=entry["withdrawn_ml"], resolution_ml=entry["resolution_ml"]
    )
    return AuditedLoad(load_g=entry["load_g"], counters=counters)


def last_attempts(records: tuple[AsRunRecord, ...]) -> dict[int, AsRunOperation]:
    """Return the last attempt at each operation."""
    return {record.number: record for record in records if isinstance(record, AsRunOperation)}
