"""A Program as a flat list of numbered operations: what is journalled, done and resumed one by one."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import dist

from planner.program import Actuate, Cure, Cut, Deposit, Machine, Pass, Program, ResetAlignment
from planner.program.as_run import Kind
from planner.program.program import Layer
from planner.program.timing import move_s, pass_s

HEATING_S = 60.0
"""Guess of the time that hot air or plate take to become hot [s]."""


@dataclass(frozen=True, kw_only=True)
class LoadChange:
    """Water in or out of the chamber over the post, which is lifted."""

    load_g: float


Step = Deposit | ResetAlignment | LoadChange | Pass | Cure | Cut | Actuate


@dataclass(frozen=True, kw_only=True)
class Operation:
    """One thing that is done whole or not at all, as far as a machine can."""

    number: int
    kind: Kind
    layer: int | None
    """0 is the bottom layer; None for what is done to the whole film."""
    step: Step
    pass_number: int | None = None
    expected_s: float
    """Time by the kinematic model [s]."""

    @property
    def title(self) -> str:
        """What it is, for people."""
        where = "film" if self.layer is None else f"layer {self.layer + 1}"
        match self.step:
            case Deposit(thickness_mm=thickness):
                what = f"deposit {thickness:g} mm"
            case ResetAlignment(temperature_c=temperature, duration_s=duration):
                what = f"hot air of {temperature:g} C for {duration:g} s"
            case LoadChange(load_g=load):
                what = f"load {load:.3g} g"
            case Pass():
                what = f"pass {self.pass_number}, {self.step.length_mm:.1f} mm"
            case Cure(duration_s=duration):
                what = f"UV for {duration:g} s"
            case Cut():
                what = "cut along the line"
            case Actuate(temperature_c=temperature, hold_s=hold):
                what = f"hot plate to {temperature:g} C, {hold:g} s"
        return f"{where}: {what}"


def list_operations(program: Program, machine: Machine) -> tuple[Operation, ...]:
    """List what a run does, in order: the layers, then the chamber is emptied, and the film cut and actuated."""
    steps = list(_steps(program))
    operations = []
    load_g, over_mm = 0.0, (0.0, 0.0)
    for number, (kind, layer, place, step) in enumerate(steps):
        operations.append(
            Operation(
                number=number,
                kind=kind,
                layer=layer,
                step=step,
                pass_number=place,
                expected_s=_expected_s(step, machine, load_g, over_mm),
            )
        )
        if isinstance(step, LoadChange):
            load_g = step.load_g
        if isinstance(step, Pass):
            load_g, over_mm = step.load_g[-1], step.points_mm[-1]
    return tuple(operations)


def _steps(program: Program) -> Iterator[tuple[Kind, int | None, int | None, Step]]:
    load_g = 0.0
    for layer in program.layers:
        yield from _layer_steps(layer, load_g)
        if layer.passes:
            load_g = layer.passes[-1].load_g[-1]
    if load_g:
        yield "load", None, None, LoadChange(load_g=0.0)
    for operation in program.finish:
        yield operation.kind, None, None, operation


def _layer_steps(layer: Layer, load_g: float) -> Iterator[tuple[Kind, int, int | None, Step]]:
    for operation in layer.operations:
        if operation.kind != "scratch":
            yield operation.kind, layer.index, None, operation
            continue
        for place, stroke in enumerate(operation.passes):
            if stroke.load_g[0] != load_g:
                yield "load", layer.index, None, LoadChange(load_g=stroke.load_g[0])
            yield "pass", layer.index, place, stroke
            load_g = stroke.load_g[-1]


def _expected_s(step: Step, machine: Machine, load_g: float, over_mm: tuple[float, float]) -> float:
    stage = machine.stage
    match step:
        case Pass():
            lift = move_s(stage.lift_mm, stage.lift_speed_mm_s, stage.acceleration_mm_s2)
            over = move_s(dist(over_mm, step.points_mm[0]), stage.travel_speed_mm_s, stage.acceleration_mm_s2)
            return over + 2 * lift + pass_s(step, stage)
        case LoadChange():
            return machine.pump.change_s(step.load_g - load_g)
        case ResetAlignment() | Cure():
            return step.duration_s
        case Actuate():
            return HEATING_S + step.hold_s
        case Deposit() | Cut():
            return HEATING_S
