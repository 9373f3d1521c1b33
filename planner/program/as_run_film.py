"""What an as-run log says about the film: the Program as it was really done, and how long each pass waited."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from planner.errors import InputError
from planner.program.as_run import ENDED, RECORD, AsRunOperation, AsRunProgram, AsRunRecord
from planner.program.operations import Pass, Scratch
from planner.program.program import Layer, Program
from planner.program.sentences import validation_sentences

SLACK = 0.1
"""Share by which a load may be below the calibration's least before it counts as less: what a gauge's noise makes."""


@dataclass(frozen=True, kw_only=True)
class AsRunFilm:
    """A film as it was really scratched."""

    planned: Program
    program: Program
    """The Program with the passes that were really made: their order, loads and speeds."""
    pass_to_cure_s: tuple[tuple[float, ...], ...]
    """For each layer and pass, the measured time from its middle to the start of the cure [s]."""
    pass_strength: tuple[tuple[float, ...], ...]
    """For each layer and pass, the share of its contraction that is left where the load was below the calibration's."""
    notes: tuple[str, ...]


def load_as_run(path: str | Path) -> AsRunFilm:
    """Read the log of a run whose layers are all cured.

    Raises:
        InputError: if the file cannot be read, is no such log, or the run has not cured all layers.
    """
    path = Path(path)
    records = read_as_run(path)
    planned = next((record.program for record in records if isinstance(record, AsRunProgram)), None)
    if planned is None:
        raise InputError(f"{path}: has no program in it; give the as-run.jsonl that `lce run` wrote")
    done = ended_operations(records)
    cures = {record.layer: record.start_s for record in done if record.kind == "cure"}
    missing = [layer.index for layer in planned.layers if layer.index not in cures]
    if missing:
        raise InputError(
            f"{path}: the run has not cured layers {', '.join(map(str, missing))}; finish it with `lce run --resume`"
        )
    notes: list[str] = []
    layers, waits, strengths = [], [], []
    for layer in planned.layers:
        strokes = [record for record in done if record.kind == "pass" and record.layer == layer.index]
        made = [(record, stroke) for record in strokes if (stroke := _scratched(record, planned))]
        layers.append(_with_passes(layer, tuple(stroke for _, stroke in made)))
        strengths.append(tuple(_strength(record, planned) for record, _ in made))
        waits.append(tuple(cures[layer.index] - (record.start_s + record.end_s) / 2 for record, _ in made))
        if len(made) < len(layer.passes):
            notes.append(f"layer {layer.index + 1}: {len(layer.passes) - len(made)} passes left no alignment")
        if weak := sum(strength < 1 for strength in strengths[-1]):
            notes.append(f"layer {layer.index + 1}: {weak} passes had less load than the calibration covers")
    program = Program(
        **{name: getattr(planned, name) for name in Program.model_fields if name not in ("layers", "name")},
        name=f"{planned.name}, as run",
        layers=tuple(layers),
    )
    return AsRunFilm(
        planned=planned,
        program=program,
        pass_to_cure_s=tuple(waits),
        pass_strength=tuple(strengths),
        notes=tuple(notes),
    )


def ended_operations(records: Iterable[AsRunRecord]) -> tuple[AsRunOperation, ...]:
    """Return how each operation ended at last, in the order of time; a stroke done again replaces the first."""
    ended = [record for record in records if isinstance(record, AsRunOperation) and record.outcome in ENDED]
    last = {record.number: record for record in ended}
    return tuple(record for record in ended if last[record.number] is record)


def read_as_run(path: str | Path) -> tuple[AsRunRecord, ...]:
    """Return the records of a log, without a torn last line.

    Raises:
        InputError: if the file cannot be read or is no such log.
    """
    return tuple(_records(Path(path)))


def _records(path: Path) -> Iterable[AsRunRecord]:
    try:
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read ({error}); give the as-run.jsonl that `lce run` wrote") from None
    for number, line in enumerate(lines, start=1):
        if not line.endswith("\n"):  # torn by a crash: the journal has it, and writes it anew when resumed
            return
        try:
            yield RECORD.validate_json(line)
        except ValidationError as error:
            raise InputError(validation_sentences(error, f"{path}, line {number}")) from None


def _loads_g(record: AsRunOperation) -> tuple[float, ...]:
    """Return what the post pressed with, as far as it is known [g]."""
    return record.post_load_g or (record.stroke.load_g if record.stroke else ())


def _strength(record: AsRunOperation, planned: Program) -> float:
    """Return the share of the least calibrated contraction that a smaller load leaves: taken as proportional to it."""
    loads, least = _loads_g(record), planned.calibration.limits.load_g_min
    return min(1.0, sum(loads) / len(loads) / (least * (1 - SLACK)))


def _scratched(record: AsRunOperation, planned: Program) -> Pass | None:
    """Return the pass that the film remembers: with the post's own load where it was measured; None if nothing."""
    stroke = record.stroke
    if stroke is None:
        return None
    limits = planned.calibration.limits
    loads = _loads_g(record)
    if max(loads) <= 0:
        return None
    return stroke.model_copy(
        update={
            "load_g": tuple(min(limits.load_g_max, max(limits.load_g_min, load)) for load in loads),
            "speed_mm_s": tuple(
                min(limits.speed_mm_s_max, max(limits.speed_mm_s_min, speed)) for speed in stroke.speed_mm_s
            ),
        }
    )


def _with_passes(layer: Layer, passes: tuple[Pass, ...]) -> Layer:
    kept = tuple(operation for operation in layer.operations if not isinstance(operation, Scratch))
    if not passes:
        return Layer(index=layer.index, operations=kept)
    place = next(i for i, operation in enumerate(layer.operations) if isinstance(operation, Scratch))
    return Layer(index=layer.index, operations=(*kept[:place], Scratch(passes=passes), *kept[place:]))
