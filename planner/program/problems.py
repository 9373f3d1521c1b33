"""What can be wrong inside a Program although each of its parts is well formed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from planner.program.geometry import is_convex, outside_convex, self_crossing
from planner.program.operations import Pass

if TYPE_CHECKING:
    from planner.program.calibration_record import CalibrationLimits
    from planner.program.program import Layer, Program

ORDERS = (
    ("deposit", "reset_alignment", "scratch", "cure"),
    ("deposit", "reset_alignment", "cure"),
)


def program_problems(program: Program) -> tuple[str, ...]:
    """Collect every contradiction in a Program, one sentence each.

    A fault that many passes of a layer share is told once, with the first place and the count.
    """
    problems = list(_film_problems(program))
    problems += _stack_problems(program)
    convex = is_convex(program.film.outline_mm)
    for place, layer in enumerate(program.layers):
        faults: dict[str, tuple[str, int]] = {}
        for number, stroke in enumerate(layer.passes):
            for kind, sentence in _pass_faults(stroke, program, convex):
                first, count = faults.get(kind, (f"layers[{place}], pass {number}: {sentence}", 0))
                faults[kind] = first, count + 1
        for sentence, count in faults.values():
            more = f" (and {count - 1} more passes of this layer likewise)" if count > 1 else ""
            problems.append(sentence + more)
    return tuple(problems)


def _film_problems(program: Program) -> Iterator[str]:
    outline = program.film.outline_mm
    if not is_convex(outline):
        yield (
            "film.outline_mm: the deposited region is not a convex, counter-clockwise polygon; give the "
            "rectangle that is deposited and let the cut shape the film"
        )
    kinds = tuple(op.kind for op in program.finish)
    if kinds != ("cut", "actuate"):
        yield f"finish: the operations are {_listed(kinds)}, allowed is cut, actuate; add or reorder them"
        return
    line = program.cut.line_mm
    crossing = self_crossing(line)
    if crossing is not None:
        yield (
            f"finish[0].line_mm: the cut line crosses itself near ({crossing[0]:.3f}, {crossing[1]:.3f}) mm, "
            "allowed is a simple closed line; redraw it"
        )
    if is_convex(outline) and (stray := outside_convex(line, outline)):
        yield (
            f"finish[0].line_mm: the cut reaches ({stray[0]:.3f}, {stray[1]:.3f}) mm, outside the deposited "
            f"region {_box(outline)}; enlarge film.outline_mm or shrink the cut"
        )


def _stack_problems(program: Program) -> Iterator[str]:
    wanted, layers = program.film.layer_thickness_mm, program.layers
    if len(wanted) != len(layers):
        yield (
            f"layers: there are {len(layers)} layers but film.layer_thickness_mm has {len(wanted)} values; "
            "give one layer for each thickness"
        )
    for place, layer in enumerate(layers):
        if layer.index != place:
            yield (
                f"layers[{place}].index: found {layer.index}, allowed is {place}; list the layers bottom first from 0"
            )
        yield from _order_problems(place, layer)
        if place < len(wanted) and abs(layer.thickness_mm - wanted[place]) > 1e-9:
            yield (
                f"layers[{place}]: deposits {layer.thickness_mm:g} mm but film.layer_thickness_mm says "
                f"{wanted[place]:g} mm; make them equal"
            )


def _order_problems(place: int, layer: Layer) -> Iterator[str]:
    kinds = tuple(op.kind for op in layer.operations)
    if kinds not in ORDERS:
        yield (
            f"layers[{place}].operations: the operations are {_listed(kinds)}, allowed is deposit, "
            "reset_alignment, scratch (or none), cure, in this order; add, remove or reorder them"
        )


def _pass_faults(stroke: Pass, program: Program, convex: bool) -> Iterator[tuple[str, str]]:
    count, limits = len(stroke.points_mm), program.calibration.limits
    if len(stroke.speed_mm_s) != count - 1:
        yield (
            "speeds",
            (
                f"speed_mm_s has {len(stroke.speed_mm_s)} values, allowed is one for each of the {count - 1} "
                "segments; plan again"
            ),
        )
    if len(stroke.load_g) not in (1, count):
        yield (
            "loads",
            (
                f"load_g has {len(stroke.load_g)} values, allowed is 1 for the pass or one for each of its "
                f"{count} points; plan again"
            ),
        )
    yield from _limit_faults(stroke, limits)
    if any(a == b for a, b in zip(stroke.points_mm, stroke.points_mm[1:], strict=False)):
        yield (
            "stands",
            "points_mm repeats a point, allowed are segments with a length; remove the repeated point",
        )
    if convex and (stray := outside_convex(stroke.points_mm, program.film.outline_mm)):
        yield (
            "outside",
            (
                f"points_mm reaches ({stray[0]:.3f}, {stray[1]:.3f}) mm, outside the deposited region "
                f"{_box(program.film.outline_mm)}; enlarge film.outline_mm or move the pass"
            ),
        )


def _limit_faults(stroke: Pass, limits: CalibrationLimits) -> Iterator[tuple[str, str]]:
    for name, unit, values in (("speed_mm_s", "mm/s", stroke.speed_mm_s), ("load_g", "g", stroke.load_g)):
        low, high = getattr(limits, f"{name}_min"), getattr(limits, f"{name}_max")
        # Rounding on the way into a file must not push a value at the limit over it.
        slack = 1e-6 * high
        if values and (min(values) < low - slack or max(values) > high + slack):
            found = min(values) if min(values) < low - slack else max(values)
            yield (
                name,
                (
                    f"{name} is {found:g} {unit}, the calibration allows {low:g} to {high:g} {unit}; "
                    "clamp it, or plan with a calibration that covers it"
                ),
            )


def _listed(kinds: tuple[str, ...]) -> str:
    return ", ".join(kinds) or "none"


def _box(outline: tuple[tuple[float, float], ...]) -> str:
    xs, ys = zip(*outline, strict=True)
    return f"x {min(xs):.3f} to {max(xs):.3f} mm, y {min(ys):.3f} to {max(ys):.3f} mm"
