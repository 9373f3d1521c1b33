"""A temperature field that was measured or calculated elsewhere."""

import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from planner.errors import InputError
from twin.film import Film
from twin.temperature.field import ROOM_C

KEYS = ("x_mm", "y_mm", "temperature_c")
PLATE_C = 150.0
"""Temperature of the plate that a file without `plate_c` belongs to [C]: the paper's."""
TEMPERATURE_C_ALLOWED = (0.0, 250.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class TemperatureFile:
    """Temperatures over the flat film; a part of the film keeps its temperature wherever it moves to.

    Between the room's and the field's own plate temperature each point warms in proportion to the plate.
    """

    kind: ClassVar[str] = "file"
    follows_shape: ClassVar[bool] = False

    source: str
    """File that it was read from."""
    x_mm: np.ndarray
    """Grid columns in the film frame [mm], ascending, shape [nx], float."""
    y_mm: np.ndarray
    """Grid rows [mm], ascending, shape [ny], float."""
    grid_c: np.ndarray
    """Temperatures [C], shape [ny, nx], float."""
    plate_c: float = PLATE_C
    """Temperature of the plate that they belong to [C]."""

    def temperature_c(self, film: Film, vertices_mm: np.ndarray, plate_c: float) -> np.ndarray:
        """Return the temperature at the flat centre of each triangle [C], shape [m].

        Raises:
            InputError: if the film reaches beyond the grid.
        """
        centre = film.flat_mm[film.triangles].mean(axis=1)
        problems = []
        for name, grid, values in (("x_mm", self.x_mm, centre[:, 0]), ("y_mm", self.y_mm, centre[:, 1])):
            if values.min() < grid[0] or values.max() > grid[-1]:
                problems.append(
                    f"temperature file {self.source}: {name} spans {grid[0]:g} to {grid[-1]:g} mm, the film "
                    f"{values.min():.1f} to {values.max():.1f} mm; extend the grid beyond the film."
                )
        if problems:
            raise InputError(problems)
        hot = RegularGridInterpolator((self.y_mm, self.x_mm), self.grid_c)(centre[:, ::-1])
        return ROOM_C + (hot - ROOM_C) * (plate_c - ROOM_C) / (self.plate_c - ROOM_C)


def load_temperature_file(path: str | Path) -> TemperatureFile:
    """Read a temperature field from an .npz file with x_mm [nx], y_mm [ny], temperature_c [ny, nx] in the film frame.

    An optional number `plate_c` tells the plate's temperature that the field belongs to, 150 C without it.

    Raises:
        InputError: with every problem found: no .npz, arrays that are missing, no numbers, or do not fit together,
            temperatures out of range.
    """
    path = Path(path)
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays = {key: archive[key] for key in archive.files}
    except (OSError, ValueError, EOFError, TypeError, zipfile.BadZipFile) as error:
        raise InputError(
            f"temperature file {path}: cannot be read as .npz ({error}); write it with numpy.savez and the arrays "
            f"{', '.join(KEYS)}."
        ) from None
    problems = [
        f"{key} is missing (the file has {', '.join(arrays) or 'nothing'}); add it" for key in KEYS if key not in arrays
    ]
    problems += [
        f"{key} is of type {arrays[key].dtype}; give real numbers"
        for key in (*KEYS, "plate_c")
        if key in arrays and arrays[key].dtype.kind not in "iuf"
    ]
    if not problems:
        x, y, grid = (np.asarray(arrays[key], dtype=float) for key in KEYS)
        plate = np.asarray(arrays.get("plate_c", PLATE_C), dtype=float)
        problems = _problems(x, y, grid, plate)
        if not problems:
            return TemperatureFile(source=str(path), x_mm=x, y_mm=y, grid_c=grid, plate_c=float(plate.item()))
    raise InputError([f"temperature file {path}: {problem}." for problem in problems])


def _problems(x: np.ndarray, y: np.ndarray, grid: np.ndarray, plate: np.ndarray) -> list[str]:
    problems = [
        f"{name} has the shape {list(values.shape)} and must be ascending finite numbers, two at least; correct it"
        for name, values in (("x_mm", x), ("y_mm", y))
        if values.ndim != 1 or len(values) < 2 or not np.isfinite(values).all() or np.any(np.diff(values) <= 0.0)
    ]
    if grid.shape != (y.size, x.size):
        problems.append(
            f"temperature_c has the shape {list(grid.shape)}, allowed is one row for each of the {y.size} y_mm "
            f"and one column for each of the {x.size} x_mm; transpose or resample it"
        )
    low, high = TEMPERATURE_C_ALLOWED
    outside = ~((grid >= low) & (grid <= high))
    if outside.any():
        problems.append(
            f"temperature_c has {outside.sum()} of {grid.size} values outside of {low:g} to {high:g} C (the first is "
            f"{grid[outside][0]:g}); fill gaps, and convert kelvin"
        )
    if plate.size != 1 or not ROOM_C < plate.item() <= high:
        problems.append(
            f"plate_c is {plate.tolist()}, allowed is one number above {ROOM_C:g} and up to {high:g} C; give the "
            "temperature of the plate when the field was measured"
        )
    return problems
