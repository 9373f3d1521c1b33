"""Structural similarity of two depth images: Eq. 4 of the paper and its variants."""

from typing import cast

import numpy as np
from skimage.metrics import structural_similarity

GREY_LOWEST = 1.0
"""Grey value of the lowest surface point; 0 is kept for the background."""
GREY_HIGHEST = 255.0
"""Grey value of the highest surface point of the target."""


def ssim_eq4(reference: np.ndarray, sample: np.ndarray, window: int = 9) -> float:
    """Mean structural similarity over all windows in which both images show some surface.

    SSIM(r, s) = (2 mu_r mu_s)(2 sigma_rs) / ((mu_r^2 + mu_s^2)(sigma_r^2 + sigma_s^2)) with uniform
    windows, stride 1, population moments and no stabilising constants. A window counts where both images
    have a non-zero pixel; 0/0 windows (both constant) are skipped. Source: Eq. 4 of the paper, section 2.4.

    Args:
        reference: Grey image of the target, 0 = background, shape [h, w], float.
        sample: Grey image of the shape in the same scale, 0 = background, shape [h, w], float.
        window: Side of the square window [px].

    Returns:
        The index, 1 for equal images, 0 where the images have no window in common.

    Raises:
        ValueError: The images differ in shape, or are smaller than one window.

    """
    values, reference_filled, sample_filled = _windows(reference, sample, window)
    return _mean_over(values, (reference_filled > 0) & (sample_filled > 0))


def ssim_eq4_inside(reference: np.ndarray, sample: np.ndarray, window: int = 9) -> float:
    """Mean of Eq. 4 over the windows that lie wholly inside both outlines; arguments as `ssim_eq4`."""
    values, reference_filled, sample_filled = _windows(reference, sample, window)
    return _mean_over(values, (reference_filled == window**2) & (sample_filled == window**2))


def ssim_eq4_own_scale(reference: np.ndarray, sample: np.ndarray, window: int = 9) -> float:
    """Mean of Eq. 4 after each image is stretched to its own 1..255; arguments as `ssim_eq4`.

    This is what a picture pipeline would do without being asked: it hides errors of height.
    """
    return ssim_eq4(_own_scale(reference), _own_scale(sample), window)


def ssim_eq4_map(reference: np.ndarray, sample: np.ndarray, window: int = 9) -> np.ndarray:
    """Eq. 4 of the window around each pixel, NaN where `ssim_eq4` counts none, shape [h, w], float."""
    values, reference_filled, sample_filled = _windows(reference, sample, window)
    counted = (reference_filled > 0) & (sample_filled > 0)
    image = np.full(np.shape(reference), np.nan)
    margin = (window - 1) // 2
    height, width = values.shape
    image[margin : margin + height, margin : margin + width] = np.where(counted, values, np.nan)
    return image


def ssim_gauss(reference: np.ndarray, sample: np.ndarray) -> float:
    """Structural similarity as usual today: 11 x 11 Gaussian windows of sigma 1.5, with constants, range 255.

    Every pixel counts, the background too. Source: Wang et al. 2004, doi 10.1109/TIP.2003.819861.
    """
    similarity = structural_similarity(
        np.asarray(reference, dtype=float),
        np.asarray(sample, dtype=float),
        data_range=255.0,
        gaussian_weights=True,
        sigma=1.5,
        use_sample_covariance=False,
    )
    return float(cast(float, similarity))


def _windows(reference: np.ndarray, sample: np.ndarray, window: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Eq. 4 of every window (NaN for 0/0) and its number of non-zero pixels in each image, each [h', w']."""
    reference, sample = np.asarray(reference, dtype=float), np.asarray(sample, dtype=float)
    if reference.shape != sample.shape or reference.ndim != 2 or min(reference.shape) < window:
        raise ValueError(
            f"two images of one shape, at least {window} x {window} px, are needed; "
            f"found {reference.shape} and {sample.shape}"
        )
    mean_r, deviation_r, filled_r = _moments(reference, window)
    mean_s, deviation_s, filled_s = _moments(sample, window)
    covariance = np.einsum("ijkl,ijkl->ij", deviation_r, deviation_s) / window**2
    variance_r = np.einsum("ijkl,ijkl->ij", deviation_r, deviation_r) / window**2
    variance_s = np.einsum("ijkl,ijkl->ij", deviation_s, deviation_s) / window**2
    denominator = (mean_r**2 + mean_s**2) * (variance_r + variance_s)
    values = np.full(denominator.shape, np.nan)
    np.divide(4.0 * mean_r * mean_s * covariance, denominator, out=values, where=denominator > 0)
    return values, filled_r, filled_s


def _moments(image: np.ndarray, window: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean [h', w'], deviations from it [h', w', n, n] and number of non-zero pixels [h', w'] of each window."""
    views = np.lib.stride_tricks.sliding_window_view(image, (window, window))
    # Deviations from the window's own first pixel: exact zeros in a constant window, so that 0/0 is
    # recognised, and no cancellation of large squares as integral images would have.
    anchor = views[:, :, :1, :1]
    offset = views - anchor
    mean_offset = offset.mean(axis=(2, 3), keepdims=True)
    mean = (anchor + mean_offset)[:, :, 0, 0]
    return mean, offset - mean_offset, np.count_nonzero(views, axis=(2, 3))


def _mean_over(values: np.ndarray, counted: np.ndarray) -> float:
    """Mean of the counted windows that have a value; 0 without any."""
    chosen = values[counted & np.isfinite(values)]
    return float(chosen.mean()) if chosen.size else 0.0


def _own_scale(image: np.ndarray) -> np.ndarray:
    """Stretch the non-zero pixels of an image to 1..255 (a flat one to 1)."""
    image = np.asarray(image, dtype=float)
    surface = image != 0
    if not surface.any():
        return image
    low, high = image[surface].min(), image[surface].max()
    scale = (GREY_HIGHEST - GREY_LOWEST) / (high - low) if high > low else 0.0
    return np.where(surface, GREY_LOWEST + (image - low) * scale, 0.0)
