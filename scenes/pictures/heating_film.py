"""Pictures of a sheet that rises as it is heated, one after the other, with the temperature of the plate."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from scenes.pictures.relief import half_height, relief_image

SIZE_PX = (576, 720)
"""Width and height, multiples of 16, which video wants."""
TITLE_PX, STRIP_PX = 48, 72
"""Heights above the sheet, with the title, and below it, with the thermometer."""
TEMPERATURE_SHARE = 0.5
"""How far time follows the plate's temperature, and for the rest the way of the sheet: it does little up to 90 C and
nearly all within ten degrees, where a film in temperature alone would only jump."""
HELD_SHARE = 0.12
"""Share of the pictures that hold the last shape."""
LEAST = 1e-6


def heating_frames(
    temperature_c: np.ndarray, vertices_mm: np.ndarray, triangles: np.ndarray, count: int, *, title: str
) -> Iterator[np.ndarray]:
    """Yield pictures of a film's way through its shapes, each [h, w, 3], uint8.

    Between the shapes that were calculated vertices follow a curve that is smooth and overshoots none of them (PCHIP).

    Args:
        temperature_c: temperature of the plate at each shape [C], shape [k].
        vertices_mm: the shapes [mm], shape [k, n, 3].
        triangles: vertex indices, shape [m, 3], int.
        count: number of pictures.
        title: written above.
    """
    from scipy.interpolate import PchipInterpolator

    size = SIZE_PX[0], SIZE_PX[1] - STRIP_PX - TITLE_PX
    place = _places(temperature_c, vertices_mm)
    shapes, temperatures = PchipInterpolator(place, vertices_mm, axis=0), PchipInterpolator(place, temperature_c)
    scale = max(half_height(shape) for shape in vertices_mm)
    moving = max(1, round(count * (1.0 - HELD_SHARE)))
    times = np.minimum(np.arange(count) / max(moving - 1, 1), 1.0)
    range_c = float(temperature_c.min()), float(temperature_c.max())
    image, shown = np.zeros(0), -1.0
    for time in times:
        if time != shown:
            sheet = relief_image(shapes(time), triangles, scale, size_px=size)
            image, shown = _labelled(sheet, float(temperatures(time)), range_c, title), float(time)
        yield image


def _places(temperature_c: np.ndarray, vertices_mm: np.ndarray) -> np.ndarray:
    """Return when each shape is reached, from 0 to 1, shape [k]."""
    warmer = np.abs(np.diff(temperature_c))
    moved = np.sqrt((np.diff(vertices_mm, axis=0) ** 2).sum(axis=2).mean(axis=1))
    steps = np.full(len(warmer), LEAST)
    for way, share in ((warmer, TEMPERATURE_SHARE), (moved, 1.0 - TEMPERATURE_SHARE)):
        steps += share * way / max(float(way.sum()), LEAST)
    return np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()


def _labelled(sheet: np.ndarray, temperature_c: float, range_c: tuple[float, float], title: str) -> np.ndarray:
    """Return the picture with its title above and a thermometer below."""
    from matplotlib import get_data_path
    from PIL import Image, ImageDraw, ImageFont

    font = Path(get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"
    image = Image.new("RGB", SIZE_PX, "white")
    image.paste(Image.fromarray(sheet), (0, TITLE_PX))
    draw = ImageDraw.Draw(image)
    draw.text((SIZE_PX[0] / 2, 16), title, fill="#1c2430", font=ImageFont.truetype(font, 18), anchor="ma")
    low, high = range_c
    left, right, line = 40, SIZE_PX[0] - 130, SIZE_PX[1] - STRIP_PX // 2
    share = (temperature_c - low) / max(high - low, LEAST)
    draw.rounded_rectangle((left, line - 7, right, line + 7), 7, fill="#e4e7ec")
    draw.rounded_rectangle((left, line - 7, left + 14 + share * (right - left - 14), line + 7), 7, fill=_warm(share))
    small = ImageFont.truetype(font, 12)
    for value, at in ((low, left), (high, right)):
        draw.text((at, line + 11), f"{value:.0f}", fill="#5a6675", font=small, anchor="ma")
    draw.text(
        (SIZE_PX[0] - 28, line),
        f"{temperature_c:.0f} °C",
        fill="#1c2430",
        font=ImageFont.truetype(font, 22),
        anchor="rm",
    )
    return np.asarray(image)


def _warm(share: float) -> tuple[int, int, int]:
    """Return a colour from blue, cold, to red, hot."""
    import matplotlib

    red, green, blue, _ = matplotlib.colormaps["coolwarm"](float(np.clip(share, 0.0, 1.0)))
    return int(255 * red), int(255 * green), int(255 * blue)
