"""A parametric human face: a large dome with smaller domes and hollows on it, as the paper describes one."""

import numpy as np

from planner.target import Target, target_from_heights
from scenes.targets.grid import bump, centred_grid, smooth_step

_SIZE = (40.0, 60.0)
"""Width and height for which the features below are laid out [mm]."""

# Each feature: x and y of its top, radii along and across, height, tilt (of the right side) in degrees.
# Everything off the axis stands on both sides.
_FEATURES = {
    "forehead": (0.0, 20.0, 12.0, 7.5, 0.9, 0.0),
    "glabella": (0.0, 13.5, 4.0, 3.5, 0.7, 0.0),
    "brow": (8.2, 14.2, 6.0, 3.0, 1.0, -8.0),
    "temple": (18.0, 12.0, 4.0, 7.0, -1.0, 0.0),
    "eye socket": (7.6, 7.8, 5.4, 4.0, -4.3, -6.0),
    "eye": (8.3, 7.6, 3.6, 2.4, 2.9, -4.0),
    "cheek": (10.8, -1.2, 5.5, 5.0, 1.5, 0.0),
    "cheek hollow": (12.0, -11.5, 4.5, 6.0, -0.9, 0.0),
    "nostril wing": (3.7, -1.6, 2.5, 2.6, 1.6, 0.0),
    "muzzle": (0.0, -11.5, 8.0, 6.5, 2.4, 0.0),
    "upper lip": (2.4, -10.3, 4.0, 2.0, 0.95, -12.0),
    "lower lip": (0.0, -15.1, 5.4, 2.3, 1.5, 0.0),
    "mouth": (0.0, -12.6, 6.6, 1.8, -1.0, 0.0),
    "mouth corner": (7.2, -12.4, 2.6, 2.4, -0.7, 0.0),
    "chin groove": (0.0, -18.8, 5.5, 2.4, -0.9, 0.0),
    "chin": (0.0, -23.4, 5.6, 4.6, 2.3, 0.0),
}


def face(*, width_mm: float = 40.0, height_mm: float = 60.0) -> Target:
    r"""Make the face within an elliptic outline; depth grows with the width.

    ::

            forehead                 + y (brow)
          brow . brow                ^
        (eye)  |  (eye)              |
         cheek / \ cheek             +--> + x,  z towards the viewer
              '-'   nose: a triangular dome with wings
             ===== two lips and the groove between
              chin

    Args:
        width_mm: Width of the outline [mm].
        height_mm: Height of the outline [mm].
    """
    scale = width_mm / _SIZE[0]
    x_mm, y_mm = centred_grid(width_mm, height_mm)
    X, Y = np.meshgrid(x_mm * _SIZE[0] / width_mm, y_mm * _SIZE[1] / height_mm)
    z = 11.5 * np.sqrt(np.maximum(1.0 - (X / 21.0) ** 2 - 0.62 * (Y / 30.0) ** 2, 0.0))
    for at_x, at_y, along, across, height, tilt in _FEATURES.values():
        for side in (1.0, -1.0) if at_x else (1.0,):
            z = z + bump(
                X, Y, at=(side * at_x, at_y), radii=(along, across), height=height, tilt_rad=side * np.deg2rad(tilt)
            )
    z = z + _nose(X, Y)
    inside = (X / _SIZE[0]) ** 2 + (Y / _SIZE[1]) ** 2 <= 0.25
    return target_from_heights("face", x_mm, y_mm, np.where(inside, scale * z, np.nan))


def _nose(X: np.ndarray, Y: np.ndarray) -> np.ndarray:
    """A dome of triangular plan: it widens and rises from the bridge to the tip and ends above the lip."""
    bridge, tip, base = 12.0, -0.2, -3.9
    down = (bridge - Y) / (bridge - tip)
    # Softened ramps, so that the bridge leaves the brow and the tip its back without a crease.
    rise = (np.logaddexp(0.0, 9.0 * down) - np.logaddexp(0.0, 9.0 * (down - 1.0))) / 9.0
    end = 1.0 / (1.0 + np.exp(-(Y - base) / 1.05))
    half_width = 2.2 + 1.6 * smooth_step(down)
    return 8.2 * rise * end * np.exp(-((X / half_width) ** 2))
