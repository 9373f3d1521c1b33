"""Fit a calibration to measured strips and write it, with its picture."""

from pathlib import Path

from planner.calibration import CalibrationFit, calibration_toml, fit_calibration, load_calibration, read_strips
from planner.errors import InputError
from scenes.output import output_folder
from scenes.pictures import draw_calibration

NOT_STATED = "not stated"


def calibrate_into(
    path: Path,
    strips: Path,
    *,
    name: str | None = None,
    provenance: dict[str, str],
    layer_thickness_mm: tuple[float, ...],
) -> CalibrationFit:
    """Fit the strips of a CSV file and write a calibration (.toml) and, beside it, its picture (.png).

    Args:
        path: the calibration to write; the picture has the same name.
        strips: the CSV file.
        name: of the calibration; None for that of the CSV file.
        provenance: what is known about the measurement.
        layer_thickness_mm: of the strips' layers, bottom first [mm].

    Raises:
        InputError: with every problem of the strips, or if the file cannot be written.
    """
    if path.suffix != ".toml":
        raise InputError(f"--out: found {path}, allowed is a file that ends in .toml; write for example {path}.toml.")
    if path.is_dir():
        raise InputError(f"--out: {path} is a folder, allowed is a file; name a file in it.")
    fit = fit_calibration(
        read_strips(strips), name=name or strips.stem, provenance=provenance, layer_thickness_mm=layer_thickness_mm
    )
    with output_folder(path.parent) as scratch:
        written = scratch / path.name
        written.write_text(calibration_toml(fit.calibration.record), encoding="utf-8")
        load_calibration(written)
        draw_calibration(scratch / f"{path.stem}.png", fit)
    return fit
