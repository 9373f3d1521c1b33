"""The preflight: can this machine do this Program? The same check before simulating and before running."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from planner.program.machine import Machine
from planner.program.operations import Actuate, Cure, Pass, ResetAlignment
from planner.program.program import Layer, Program
from planner.program.segments import describe_split, split_layer
from planner.program.timing import LayerTime, layer_times


@dataclass(frozen=True, kw_only=True)
class Problem:
    """One finding of the preflight."""

    severity: Literal["error", "warning"]
    """`error`: the machine cannot or must not do it. `warning`: it can, and the film may suffer."""
    where: str
    """Place in the Program, as `layers[1], pass 17`."""
    message: str
    """What is wrong, the value found, what is allowed, what to do."""


def check(program: Program, machine: Machine) -> tuple[Problem, ...]:
    """Collect every reason why the machine should not run the Program: errors first, in the Program's order.

    A fault that many passes of a layer share is told once, with the first place and the count.
    """
    problems: list[Problem] = []
    for layer, time in zip(program.layers, layer_times(program, machine), strict=True):
        problems += _pass_problems(layer, machine)
        problems += _heat_problems(layer, machine)
        problems += _time_problems(layer, time, machine)
    plate = machine.heat.hot_plate_c_max
    for place, operation in enumerate(program.finish):
        if isinstance(operation, Actuate) and operation.temperature_c > plate:
            message = f"the plate is to reach {operation.temperature_c:g} C, the machine allows {plate:g} C; lower it"
            problems.append(Problem(severity="error", where=f"finish[{place}]", message=message))
    return tuple(sorted(problems, key=lambda problem: problem.severity))


def _pass_problems(layer: Layer, machine: Machine) -> Iterator[Problem]:
    faults: dict[str, tuple[int, str, int]] = {}
    for number, stroke in enumerate(layer.passes):
        for kind, message in _pass_faults(stroke, machine):
            first, text, count = faults.get(kind, (number, message, 0))
            faults[kind] = first, text, count + 1
    for first, text, count in faults.values():
        more = f" (and {count - 1} more passes of this layer likewise)" if count > 1 else ""
        yield Problem(severity="error", where=f"layers[{layer.index}], pass {first}", message=text + more)


def _pass_faults(stroke: Pass, machine: Machine) -> Iterator[tuple[str, str]]:
    stage, pump = machine.stage, machine.pump
    for axis, name, (low, high) in ((0, "x", stage.x_mm), (1, "y", stage.y_mm)):
        values = [point[axis] for point in stroke.points_mm]
        if min(values) < low or max(values) > high:
            found = min(values) if min(values) < low else max(values)
            yield (
                name,
                (
                    f"{name} = {found:.3f} mm, the stage reaches {low:g} to {high:g} mm; make the film "
                    "smaller or place it in the middle"
                ),
            )
    slow, fast = stage.scratch_speed_mm_s
    if min(stroke.speed_mm_s) < slow or max(stroke.speed_mm_s) > fast:
        found = min(stroke.speed_mm_s) if min(stroke.speed_mm_s) < slow else max(stroke.speed_mm_s)
        yield "speed", (f"the speed is {found:g} mm/s, the machine scratches at {slow:g} to {fast:g} mm/s; plan again")
    heaviest = max(stroke.load_g)
    if heaviest > pump.load_g_max:
        yield "load", f"the load is {heaviest:g} g, the machine allows {pump.load_g_max:g} g; plan again"
    if heaviest * pump.ml_per_g > pump.syringe_ml:
        yield (
            "volume",
            (
                f"the load needs {heaviest * pump.ml_per_g:g} mL, the syringe holds {pump.syringe_ml:g} mL; "
                "fit a larger syringe"
            ),
        )
    yield from _pump_rate_faults(stroke, machine)


def _pump_rate_faults(stroke: Pass, machine: Machine) -> Iterator[tuple[str, str]]:
    if len(stroke.load_g) == 1:
        return
    segments = zip(stroke.segment_lengths_mm, stroke.speed_mm_s, stroke.load_g, stroke.load_g[1:], strict=False)
    for length, speed, before, after in segments:
        needed, there = machine.pump.change_s(after - before), length / speed
        if needed > there:
            yield (
                "pump",
                (
                    f"the load changes from {before:g} to {after:g} g within {there:.1f} s, the pump needs "
                    f"{needed:.1f} s; change loads between passes and speeds along them"
                ),
            )
            return


def _heat_problems(layer: Layer, machine: Machine) -> Iterator[Problem]:
    heat = machine.heat
    for place, operation in enumerate(layer.operations):
        where = f"layers[{layer.index}].operations[{place}]"
        if isinstance(operation, ResetAlignment) and operation.temperature_c > heat.hot_air_c_max:
            message = (
                f"the hot air is to reach {operation.temperature_c:g} C, the machine allows "
                f"{heat.hot_air_c_max:g} C; lower it"
            )
            yield Problem(severity="error", where=where, message=message)
        if isinstance(operation, Cure) and operation.wavelength_nm != heat.lamp_wavelength_nm:
            message = (
                f"the cure wants {operation.wavelength_nm:g} nm, the lamp has {heat.lamp_wavelength_nm:g} "
                "nm; change the lamp or the program"
            )
            yield Problem(severity="error", where=where, message=message)


def _time_problems(layer: Layer, time: LayerTime, machine: Machine) -> Iterator[Problem]:
    budget, life = machine.layer.budget_s, machine.layer.alignment_life_s
    if time.total_s <= budget:
        return
    segments = split_layer(layer.passes, machine)
    fits = all(segment.scratch_s <= budget for segment in segments)
    remedy = (
        f"split it into {len(segments)} segments ({describe_split(segments)})"
        if fits
        else "one pass alone takes longer: make the film smaller"
    )
    fate = "loses its first passes before the cure" if time.total_s > life else "fades a little before the cure"
    yield Problem(
        severity="error" if time.total_s > life else "warning",
        where=f"layers[{layer.index}]",
        message=(
            f"scratching takes {time.total_s / 60:.0f} min, the budget is {budget / 60:.0f} min and "
            f"alignment lasts {life / 60:.0f} min: the layer {fate}; {remedy}"
        ),
    )
