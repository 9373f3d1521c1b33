"""Weighted least-squares planes around every grid node: smoothing, slopes and filling in one operation."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

RIDGE = 1e-6
"""Slope penalty relative to the squared width: only decides where all neighbours lie on one line."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LocalPlanes:
    """Planes z = value + slope_x dx + slope_y dy fitted around each node of a grid."""

    value_mm: np.ndarray
    """Height of the fitted plane at the node [mm], NaN without support, shape [ny, nx]."""
    slope_x: np.ndarray
    """Slope of the fitted plane along x [1], shape [ny, nx]."""
    slope_y: np.ndarray
    """Slope of the fitted plane along y [1], shape [ny, nx]."""
    support: np.ndarray
    """Sum of weights seen through the Gaussian window of peak 1, shape [ny, nx]."""


def local_planes(
    z_mm: np.ndarray, weights: np.ndarray, *, spacing_mm: tuple[float, float], sigma_mm: float
) -> LocalPlanes:
    """Fit a plane around each node with Gaussian weights (normalised convolution of order one).

    Unlike a plain Gaussian filter it keeps planes exactly, also beside missing data, so that it can be
    evaluated a little beyond the border. Source: Knutsson and Westin 1993, doi:10.1109/CVPR.1993.341081.

    Args:
        z_mm: Heights [mm], shape [ny, nx]; ignored (NaN allowed) where the weight is zero.
        weights: Non-negative weights, shape [ny, nx].
        spacing_mm: Grid spacing (x, y) [mm].
        sigma_mm: Standard deviation of the window [mm].

    """
    known = weights > 0
    base = float(z_mm[known].mean())
    weighted = np.where(known, z_mm - base, 0.0) * weights
    (gx0, gx1, gx2), (gy0, gy1, gy2) = (_moments(step, sigma_mm) for step in spacing_mm)

    def window(field: np.ndarray, along_x: np.ndarray, along_y: np.ndarray) -> np.ndarray:
        rows = ndimage.correlate1d(field, along_x, axis=1, mode="constant")
        return ndimage.correlate1d(rows, along_y, axis=0, mode="constant")

    w = weights.astype(float)
    support = window(w, gx0, gy0)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        mx, my = window(w, gx1, gy0) / support, window(w, gx0, gy1) / support
        ridge = RIDGE * sigma_mm**2
        cxx = window(w, gx2, gy0) / support - mx * mx + ridge
        cyy = window(w, gx0, gy2) / support - my * my + ridge
        cxy = window(w, gx1, gy1) / support - mx * my
        mz = window(weighted, gx0, gy0) / support
        cxz = window(weighted, gx1, gy0) / support - mx * mz
        cyz = window(weighted, gx0, gy1) / support - my * mz
        det = cxx * cyy - cxy * cxy
        slope_x = (cyy * cxz - cxy * cyz) / det
        slope_y = (cxx * cyz - cxy * cxz) / det
        value = base + mz - slope_x * mx - slope_y * my
    return LocalPlanes(value_mm=value, slope_x=slope_x, slope_y=slope_y, support=support)


def fill_heights(z_mm: np.ndarray, wanted: np.ndarray, *, spacing_mm: tuple[float, float]) -> np.ndarray:
    """Fill the wanted NaN nodes from planes through their surroundings, the narrowest window that reaches.

    Args:
        z_mm: Heights [mm], NaN where unknown, shape [ny, nx].
        wanted: Nodes that must have a height afterwards, shape [ny, nx], bool.
        spacing_mm: Grid spacing (x, y) [mm].

    """
    filled = z_mm.copy()
    known = np.isfinite(z_mm)
    missing = wanted & ~known
    sigma = 0.75 * max(spacing_mm)
    while missing.any():
        planes = local_planes(z_mm, known.astype(float), spacing_mm=spacing_mm, sigma_mm=sigma)
        reached = missing & (planes.support > 0.5)
        filled[reached] = planes.value_mm[reached]
        missing &= ~reached
        sigma *= 2.0
    return filled


def _moments(step_mm: float, sigma_mm: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gaussian window of peak 1 and its first two moments on a grid [1, mm, mm^2]."""
    reach = max(1, int(np.ceil(4.0 * sigma_mm / step_mm)))
    offset = step_mm * np.arange(-reach, reach + 1)
    gauss = np.exp(-0.5 * (offset / sigma_mm) ** 2)
    return gauss, gauss * offset, gauss * offset**2
