"""Everything numeric as CSV and NPZ."""

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from planner.calibration import Calibration
from planner.program import Program


def write_pass_tables(folder: Path, program: Program) -> None:
    """Write all points of all passes into passes.csv and passes.npz.

    Layers and passes count from 1. The speed of a row is that on the way to it, and NaN (empty in CSV) at the start of
    a pass; radius and contraction are what the calibration promises for that way.
    """
    calibration = Calibration(program.calibration)
    rows: list[tuple[Any, ...]] = []
    for layer in program.layers:
        for number, stroke in enumerate(layer.passes, 1):
            loads = np.broadcast_to(stroke.load_g, (len(stroke.points_mm),))
            between = (loads[1:] + loads[:-1]) / 2.0
            radius = [np.nan, *calibration.radius_mm(between, stroke.speed_mm_s)]
            contraction = [np.nan, *calibration.contraction(between, stroke.speed_mm_s)]
            speeds = (np.nan, *stroke.speed_mm_s)
            rows += [
                (layer.index + 1, number, point, x, y, load, speed, stroke.side, r, e)
                for point, ((x, y), load, speed, r, e) in enumerate(
                    zip(stroke.points_mm, loads, speeds, radius, contraction, strict=True), 1
                )
            ]
    names = ("layer", "pass", "point", "x_mm", "y_mm", "load_g", "speed_mm_s", "side", "radius_mm", "contraction")
    write_table(folder / "passes.csv", names, rows)
    columns = zip(*rows, strict=True) if rows else [()] * len(names)
    arrays: dict[str, Any] = {name: np.array(column) for name, column in zip(names, columns, strict=True)}
    np.savez_compressed(
        folder / "passes.npz",
        **arrays,
        cut_mm=np.array(program.cut.line_mm),
        deposited_mm=np.array(program.film.outline_mm),
    )


def write_result_tables(folder: Path, result: dict[str, Any], scan: dict[str, Any] | None) -> None:
    """Write every number of result.json into result.csv, and the depth images into depth.csv and depth.npz."""
    write_table(folder / "result.csv", ("name", "value"), _numbers(result))
    if scan is None:
        return
    np.savez_compressed(folder / "depth.npz", **scan)
    x, y = np.meshgrid(scan["x_mm"], scan["y_mm"])
    columns = (x.ravel(), y.ravel(), scan["z_mm"].ravel(), scan["target_z_mm"].ravel())
    names = ("x_mm", "y_mm", "z_mm", "target_z_mm")
    write_table(folder / "depth.csv", names, np.column_stack(columns).tolist())


def write_table(path: Path, names: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """Write a CSV file; NaN becomes an empty cell."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        writer.writerows([["" if value != value else _plain(value) for value in row] for row in rows])


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _numbers(value: Any, name: str = "") -> list[tuple[str, float]]:
    """Return all numbers of nested dictionaries and lists with their places, as `equilibrium.energy_mj`."""
    if isinstance(value, dict):
        return [pair for key, part in value.items() for pair in _numbers(part, f"{name}.{key}" if name else str(key))]
    if isinstance(value, list):
        return [pair for place, part in enumerate(value) for pair in _numbers(part, f"{name}[{place}]")]
    return [(name, value)] if isinstance(value, int | float) and not isinstance(value, bool) else []
