"""A run with one of everything, small enough to be repeated a thousand times."""

from planner.calibration import load_calibration
from planner.program import (
    Actuate,
    CreatedBy,
    Cure,
    Cut,
    Deposit,
    Film,
    Inputs,
    Layer,
    Pass,
    Program,
    ResetAlignment,
    Scratch,
)
from rig.machine_file import RigDescription, load_rig

SQUARE = ((-20.0, -20.0), (20.0, -20.0), (20.0, 20.0), (-20.0, 20.0))
AREA_MM2 = 1600.0


def small_program() -> Program:
    """Return a Program of two layers: three passes with two loads, and one whose load changes along it."""
    bottom = (
        Pass(points_mm=((-4, 0), (4, 0)), speed_mm_s=(2,), load_g=(2,), side="convex"),
        Pass(points_mm=((4, 1), (0, 1), (0, 5)), speed_mm_s=(2, 1), load_g=(2,), side="convex"),
        Pass(points_mm=((1, 5), (3, 2), (5, 5)), speed_mm_s=(1.5, 2), load_g=(3,), side="convex"),
    )
    top = (Pass(points_mm=((-5, -3), (0, -3), (5, -3)), speed_mm_s=(1, 1), load_g=(1.0, 1.3, 1.1), side="concave"),)
    return Program(
        name="small",
        seed=0,
        created_by=CreatedBy(name="reliability", version="0"),
        inputs=Inputs(method="manual"),
        calibration=load_calibration().record,
        film=Film(outline_mm=SQUARE, layer_thickness_mm=(0.2, 0.2)),
        layers=tuple(
            Layer(
                index=index,
                operations=(
                    Deposit(thickness_mm=0.2),
                    ResetAlignment(duration_s=5),
                    Scratch(passes=passes),
                    Cure(duration_s=10),
                ),
            )
            for index, passes in enumerate((bottom, top))
        ),
        finish=(Cut(line_mm=((-9, -9), (9, -9), (9, 9))), Actuate(hold_s=5)),
    )


def small_rig() -> RigDescription:
    """Return the simulated rig."""
    return load_rig()
