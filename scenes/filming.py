"""The heating of a prediction as a film: MP4, GIF, a folder of pictures, or a strip of a few shapes in one picture."""

import json
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from planner.errors import InputError
from scenes.output import output_folder
from scenes.pictures import draw_heating_strip, heating_frames

HEATING_FILE = "heating.npz"
FRAMES_PER_S = 25
FRAMES, STRIP_FRAMES = 150, 6
"""Pictures of a film and of a strip, unless another number is asked for."""
MOST_STRIP_FRAMES = 60
ALLOWED = "a file that ends in .mp4, .gif or .png, or a folder for pictures"


def film_into(
    out: Path, prediction: Path, *, frames: int | None = None, progress: Callable[[str, float], None] | None = None
) -> int:
    """Film the heating of a prediction's folder, and return the number of pictures.

    Args:
        out: film (.mp4, .gif), strip (.png), or folder for pictures named frame_0001.png and so on.
        prediction: folder that `lce predict` wrote.
        frames: number of pictures, 25 a second; None for 150, of a strip 6.
        progress: called with the stage's name and the share done, 0 to 1.

    Raises:
        InputError: if the prediction cannot be read, or the film not be written.
    """
    kind = out.suffix.lower()
    if kind not in (".mp4", ".gif", ".png", ""):
        raise InputError(f"--out: found {out}, allowed is {ALLOWED}; write for example heating.gif.")
    if kind == ".mp4" and find_spec("imageio_ffmpeg") is None:
        raise InputError(
            f"--out: {out} needs the package imageio-ffmpeg, which is not installed; install it (pip install "
            "'lce-twin[film]'), or write a .gif or a folder."
        )
    if kind == ".png" and frames is not None and frames > MOST_STRIP_FRAMES:
        raise InputError(
            f"--frames: found {frames}, allowed are 2 to {MOST_STRIP_FRAMES} in a strip; a folder takes more pictures."
        )
    arrays, title = _heating(prediction)
    if kind == ".png":
        count = frames or STRIP_FRAMES
        with output_folder(out.parent) as scratch:
            draw_heating_strip(scratch / out.name, **arrays, count=count, title=title)
        return count
    frames = frames or FRAMES
    pictures = heating_frames(**arrays, count=frames, title=title)
    if progress is not None:
        pictures = _counted(pictures, frames, progress)
    with output_folder(out.parent if kind else out) as scratch:
        _write(scratch / out.name if kind else scratch, pictures, kind)
    return frames


def _heating(prediction: Path) -> tuple[dict[str, np.ndarray], str]:
    """Return the arrays of heating.npz and what to write above the film."""
    path = prediction / HEATING_FILE
    if not path.is_file():
        raise InputError(f"{prediction}: holds no {HEATING_FILE}, allowed is the folder of a prediction; name one.")
    try:
        with path.open("rb") as file, np.load(file) as archive:
            arrays = {name: archive[name] for name in ("temperature_c", "vertices_mm", "triangles")}
        result = prediction / "result.json"
        name = json.loads(result.read_text(encoding="utf-8"))["name"] if result.is_file() else prediction.name
    except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
        raise InputError(f"{prediction}: cannot be read ({error}); predict again.") from error
    if len(arrays["temperature_c"]) < 2:
        raise InputError(f"{path}: holds one shape, two or more make a film; predict at a higher temperature.")
    return arrays, f"{name}: predicted heating"


def _counted(
    pictures: Iterator[np.ndarray], count: int, progress: Callable[[str, float], None]
) -> Iterator[np.ndarray]:
    for number, picture in enumerate(pictures, 1):
        yield picture
        progress("film", number / count)


def _write(path: Path, pictures: Iterator[np.ndarray], kind: str) -> None:
    import imageio.v2 as imageio

    if not kind:
        for number, picture in enumerate(pictures, 1):
            imageio.imwrite(path / f"frame_{number:04d}.png", picture)
        return
    settings: dict[str, Any] = {".mp4": {"fps": FRAMES_PER_S, "quality": 8}, ".gif": {"duration": 40, "loop": 0}}
    writer: Any = imageio.get_writer(path, **settings[kind])
    with writer:
        for picture in pictures:
            writer.append_data(picture)
