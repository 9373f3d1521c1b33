"""What must fit together between the parts of a rig's file, and with the machine that it names."""

from math import pi
from pathlib import Path

from planner.program import Machine
from rig.dialects.new_era import SPEED_MM_MIN
from rig.rig_file import RigFile


def line_problems(file: RigFile, path: Path) -> list[str]:
    """Compare the ports: two devices never share one."""
    problems, taken = [], dict[str, str]()
    for name, line in file.lines().items():
        if line.transport != "serial" or line.port is None:
            continue
        if line.port in taken:
            section = name if name in ("stage", "pump") else f"{name}_line"
            other = taken[line.port]
            problems.append(
                f"{path}: {section}.port is {line.port!r}, which is the {other}'s port too; give each its own"
            )
        taken.setdefault(line.port, name.replace("_", " "))
    return problems


def section_problems(file: RigFile, path: Path) -> list[str]:
    """Compare who does what with the sections that this needs."""
    needed = [
        ("extruder", file.extruder == "simulated", "deposition", file.deposition),
        ("hot_plate", file.hot_plate == "namur", "hot_plate_line", file.hot_plate_line),
        ("balance", file.balance == "sics", "balance_line", file.balance_line),
    ]
    problems = []
    for key, wanted, section, found in needed:
        if wanted and found is None:
            problems.append(f"{path}: {key} is {getattr(file, key)!r}, but section [{section}] is missing; add it")
    return problems


def reach_problems(file: RigFile, machine: Machine, path: Path) -> list[str]:
    """Compare where the machine has to get with where the controller gets."""
    problems, stage, line = [], machine.stage, file.stage
    needed = (stage.x_mm, stage.y_mm, (0.0, stage.lift_max_mm))
    for name, reach, origin, allowed in zip("xyz", needed, line.origin_mm, line.reach_mm, strict=True):
        low, high = (origin + at for at in reach)
        if low < allowed[0] or high > allowed[1]:
            problems.append(
                f"{path}: stage.origin_mm puts the reach of {name}, {reach[0]:g} to {reach[1]:g} mm by machine "
                f"{machine.name!r}, at {low:g} to {high:g} mm of the controller, allowed is {allowed[0]:g} to "
                f"{allowed[1]:g}; change origin_mm, travel_mm or the machine"
            )
    return problems


def syringe_problems(file: RigFile, machine: Machine, path: Path) -> list[str]:
    """Compare the syringe with the rate and the loads that the machine asks for."""
    problems = []
    pump, diameter_mm = machine.pump, file.pump.syringe_diameter_mm
    area_mm2 = pi / 4 * diameter_mm**2
    low, high = (speed * area_mm2 * 1e-3 for speed in SPEED_MM_MIN)
    if not low <= pump.rate_ml_min <= high:
        problems.append(
            f"{path}: pump.syringe_diameter_mm is {diameter_mm:g}, with which the pump makes {low:.2g} to {high:.4g} "
            f"mL/min, but machine {machine.name!r} has pump.rate_ml_min = {pump.rate_ml_min:g}; change one of them"
        )
    needed_ml = pump.load_g_max * pump.ml_per_g
    if needed_ml > pump.syringe_ml:
        problems.append(
            f"{path}: machine {machine.name!r} has pump.syringe_ml = {pump.syringe_ml:g}, but its largest load needs "
            f"{needed_ml:g} mL; take a larger syringe or a smaller load_g_max"
        )
    return problems


def balance_problems(file: RigFile, machine: Machine, path: Path) -> list[str]:
    """Compare the place of the balance with the stage's reach."""
    line, stage = file.balance_line, machine.stage
    if file.balance == "none" or line is None:
        return []
    reaches = (("at_mm[0]", line.at_mm[0], stage.x_mm), ("at_mm[1]", line.at_mm[1], stage.y_mm))
    heights = (("pan_mm", line.pan_mm, (-file.stage.origin_mm[2] + file.stage.reach_mm[2][0], stage.lift_mm)),)
    return [
        f"{path}: balance_line.{name} is {at:g}, allowed is {low:g} to {high:g} mm, as far as the post gets; move the "
        "balance"
        for name, at, (low, high) in (*reaches, *heights)
        if not low <= at <= high
    ]
