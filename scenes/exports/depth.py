"""Depth images as 16-bit grey PNGs, with their scale beside them."""

from pathlib import Path

import numpy as np

from scenes.output import write_json

WHITE = 65535


def write_depth_images(folder: Path, scan: dict[str, np.ndarray]) -> None:
    """Write shape_depth.png, target_depth.png and depth.json into `folder`.

    Both images have one scale: height = lowest_mm + (grey - 1) mm_per_step, grey 0 where there is nothing.

    Args:
        folder: where to write.
        scan: arrays of a prediction's scan.npz: x_mm [w], y_mm [h], z_mm and target_z_mm [h, w], the lowest y first.
    """
    import imageio.v3 as imageio

    images = {"shape_depth.png": scan["z_mm"], "target_depth.png": scan["target_z_mm"]}
    heights = np.concatenate([image[np.isfinite(image)] for image in images.values()])
    lowest, step = float(heights.min()), max(float(np.ptp(heights)), 1e-9) / (WHITE - 1)
    for name, image in images.items():
        grey = np.where(np.isfinite(image), np.rint((image - lowest) / step) + 1, 0)
        # The first row of an image is at its top.
        imageio.imwrite(folder / name, grey[::-1].astype(np.uint16))
    x, y = scan["x_mm"], scan["y_mm"]
    write_json(
        folder / "depth.json",
        {
            "files": list(images),
            "height_mm": "lowest_mm + (grey - 1) * mm_per_step",
            "lowest_mm": lowest,
            "mm_per_step": step,
            "background_grey": 0,
            "width_px": len(x),
            "height_px": len(y),
            "pixel_width_mm": float(x[1] - x[0]),
            "pixel_height_mm": float(y[1] - y[0]),
            "first_pixel_centre_mm": [float(x[0]), float(y[-1])],
            "axes": "x grows with the column, y falls with the row",
        },
    )
