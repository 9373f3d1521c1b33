"""Calibrations as TOML files."""

from pathlib import Path

from planner.calibration.calibration import Calibration
from planner.errors import InputError
from planner.program import CalibrationRecord, read_toml

PLACEHOLDER = Path(__file__).with_name("placeholder.toml")
RANGE_TOLERANCE = 0.02
"""How far the model's own end radii may be from the limits that the file states, relative."""


def load_calibration(path: str | Path | None = None) -> Calibration:
    """Read a calibration; without a path the placeholder, which is not measured and says so.

    Raises InputError with every problem found: unreadable file, unknown or missing key, wrong range, or a
    model whose own radii are not those of the stated limits.
    """
    path = PLACEHOLDER if path is None else Path(path)
    record = read_toml(path, CalibrationRecord, "calibration")
    try:
        calibration = Calibration(record)
        problems = _range_problems(calibration)
    except ValueError as error:
        raise InputError(f"{path}: limits or strip: {error}; correct the calibration") from None
    if problems:
        raise InputError([f"{path}: {problem}" for problem in problems])
    return calibration


def _range_problems(calibration: Calibration) -> list[str]:
    limits = calibration.record.limits
    strongest = (limits.load_g_max, limits.speed_mm_s_min)
    weakest = (limits.load_g_min, limits.speed_mm_s_max)
    problems = []
    for key, (load, speed) in (("radius_mm_min", strongest), ("radius_mm_max", weakest)):
        stated, given = getattr(limits, key), float(calibration.radius_mm(load, speed))
        if abs(given / stated - 1) > RANGE_TOLERANCE:
            problems.append(
                f"limits.{key} is {stated:g} mm but the model gives {given:.3g} mm at {load:g} g and "
                f"{speed:g} mm/s; make them agree within 2 %"
            )
    return problems
