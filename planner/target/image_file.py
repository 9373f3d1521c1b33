"""Grey images as height maps."""

from pathlib import Path

import imageio.v3 as iio
import numpy as np

from planner.errors import InputError
from planner.target.coarsen import coarsen
from planner.target.local_planes import local_planes
from planner.target.mesh_heights import GridHeights
from planner.target.print_size import Size, print_scale

IMAGE_SUFFIXES = (".png", ".tif", ".tiff")
"""Image formats; 8 or 16 bits a pixel."""
UNSTEP_PIXELS = 2.0
"""Width of the window that smooths the steps of the grey scale [pixels]."""
UNSTEP_ROUNDS = 5
"""Rounds of smoothing; each stays within half a step of the file's value."""


def read_image(path: Path, *, size_mm: Size | None, depth_mm: float | None, name: str) -> GridHeights:
    """Read a depth image: 0 is outside the surface, brighter is higher, the upper row has the largest y.

    The darkest grey of the surface is its lowest, the brightest its highest point. An image has no unit: its
    pixels are square, and the surface fills the box `size_mm`. The steps of the grey scale are smoothed, no height
    by more than half a step.

    Raises:
        InputError: The file is no grey image of 8 or 16 bits, is all background, or size or depth is missing.
    """
    problems = []
    if depth_mm is None or not (np.isfinite(depth_mm) and depth_mm > 0):
        found = "none is given" if depth_mm is None else f"{depth_mm} is given"
        problems.append(
            f"{name}: an image needs the depth in mm between its darkest and its brightest grey, and {found}; "
            "add for example --depth-mm 18."
        )
    if size_mm is None:
        problems.append(f"{name}: an image does not say how large the surface is; add for example --size-mm 40x60.")
    if problems or depth_mm is None or size_mm is None:
        raise InputError(problems)
    grey = _grey(path, name)
    present = grey > 0
    if not present.any():
        raise InputError(f"{name}: all pixels of {path} are 0, which means outside; the surface must be brighter.")
    rows, columns = (np.flatnonzero(present.any(axis=axis)) for axis in (1, 0))
    extent = (float(np.ptp(columns)) + 1.0, float(np.ptp(rows)) + 1.0)
    pixel_mm = print_scale(extent, size_mm, name=name)

    lowest, highest = float(grey[present].min()), float(grey[present].max())
    unit_mm = depth_mm / max(highest - lowest, 1.0)
    # A border of background keeps half a pixel for the outline; row 0 of an image is its upper edge.
    z = np.pad(np.where(present, (grey - lowest) * unit_mm, np.nan), 2, constant_values=np.nan)[::-1]
    x, y = pixel_mm * np.arange(z.shape[1]), pixel_mm * np.arange(z.shape[0])
    x, y, z = coarsen(x, y, _without_steps(z, pixel_mm, unit_mm))
    note = f"The image's greys {lowest:g} to {highest:g} were read as heights from 0 to {depth_mm:g} mm."
    return GridHeights(x_mm=x, y_mm=y, z_mm=z, notes=(note,))


def _grey(path: Path, name: str) -> np.ndarray:
    """Read the pixels as grey values, fully transparent ones as background, shape [rows, columns], float."""
    try:
        pixels = np.asarray(iio.imread(path.read_bytes(), extension=path.suffix.lower()))
    except Exception as error:  # the readers behind imageio raise whatever they meet
        raise InputError(
            f"{name}: {path} cannot be read as an image ({type(error).__name__}: {error}); save it again as .png."
        ) from error
    if pixels.dtype not in (np.uint8, np.uint16):
        raise InputError(f"{name}: {path} has pixels of type {pixels.dtype}; allowed are grey values of 8 or 16 bits.")
    if pixels.ndim == 2:
        return pixels.astype(float)
    if pixels.ndim != 3 or pixels.shape[2] not in (2, 3, 4):
        raise InputError(f"{name}: {path} has shape {pixels.shape}; allowed is one grey image.")
    colours = pixels[..., : 1 if pixels.shape[2] == 2 else 3]
    if (colours != colours[..., :1]).any():
        raise InputError(f"{name}: {path} is a colour image; a height map is grey: save it in greyscale.")
    opaque = pixels[..., -1] > 0 if pixels.shape[2] in (2, 4) else np.True_
    return np.where(opaque, colours[..., 0], 0).astype(float)


def _without_steps(z: np.ndarray, pixel_mm: float, step_mm: float) -> np.ndarray:
    """Smooth heights as far as the steps of the grey scale leave them open."""
    present = np.isfinite(z)
    smooth = z
    for _ in range(UNSTEP_ROUNDS):
        planes = local_planes(
            smooth,
            present.astype(float),
            spacing_mm=(pixel_mm, pixel_mm),
            sigma_mm=UNSTEP_PIXELS * pixel_mm,
        )
        smooth = np.clip(planes.value_mm, z - 0.5 * step_mm, z + 0.5 * step_mm)
    return smooth
