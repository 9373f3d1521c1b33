"""Pictures of a sheet that rises as it is heated, one after the other, with the temperature of the plate."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from scenes.pictures.heating_way import heating_way
from scenes.pictures.relief import half_height, relief_image

SIZE_PX = (576, 720)
"""Width and height, multiples of 16, which video wants."""
TITLE_PX, STRIP_PX = 48, 72
"""Heights above the sheet, with the title, and below it, with the thermometer."""
HELD_SHARE = 0.12
"""Share of the pictures that hold the last shape."""


def heating_frames(
    temperature_c: np.ndarray, vertices_mm: np.ndarray, triangles: np.ndarray, count: int, *, title: str
) -> Iterator[np.ndarray]:
    """Yield pictures of a film's way through its shapes (see `heating_way`), each [h, w, 3], uint8.

    Args:
        temperature_c: temperature of the plate at each shape [C], shape [k].
        vertices_mm: the shapes [mm], shape [k, n, 3].
        triangles: vertex indices, shape [m, 3], int.
        count: number of pictures.
        title: written above.
    """
    size = SIZE_PX[0], SIZE_PX[1] - STRIP_PX - TITLE_PX
    way = heating_way(temperature_c, vertices_mm)
    scale = max(half_height(shape) for shape in vertices_mm)
    moving = max(1, round(count * (1.0 - HELD_SHARE)))
    times = np.minimum(np.arange(count) / max(moving - 1, 1), 1.0)
    image, shown = np.zeros(0), -1.0
    for time in times:
        if time != shown:
            shape, plate_c = way.at(time)
            sheet = relief_image(shape, triangles, scale, size_px=size)
            image, shown = _labelled(sheet, plate_c, way.range_c, title), float(time)
        yield image


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
    share = (temperature_c - low) / (high - low) if high > low else 1.0
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
