"""What the similarity indices say of simple errors of height; print the Markdown table of docs/concepts/score.md.

python -m benchmarks.similarity
"""

import numpy as np
from scipy.ndimage import gaussian_filter

from scenes.case import load_case
from twin.scan import grey_image, pixel_centres, target_depth_image
from twin.score import ssim_eq4, ssim_eq4_own_scale, ssim_gauss


def errors_mm(depth: np.ndarray, x_mm: np.ndarray, y_mm: np.ndarray) -> dict[str, np.ndarray]:
    """Return images of depth with one error each [mm], by what it is."""
    rng = np.random.default_rng(0)
    white = rng.standard_normal(depth.shape)
    top = float(np.nanmax(depth))
    share = np.maximum(gaussian_filter(1.0 * np.isfinite(depth), 2.5), 0.1)
    smoothed = gaussian_filter(np.nan_to_num(depth), 2.5) / share
    return {
        "none": depth,
        "1 mm higher everywhere": depth + 1.0,
        "tilted by 1 mm at the rims": depth + x_mm / np.nanmax(x_mm),
        "a broad bulge of 1 mm in the middle": depth + np.exp(-(x_mm**2 + y_mm**2) / 12.0**2),
        "all heights times 0.7": 0.7 * depth,
        "noise of 0.05 mm in each pixel": depth + 0.05 * white,
        "noise of 0.15 mm in each pixel, as a phone's": depth + 0.15 * white,
        "features smoothed over 1 mm": np.where(np.isnan(depth), np.nan, smoothed),
        "turned inside out": top - depth,
    }


def main() -> None:
    target = load_case("face").make_target()
    depth = target_depth_image(target)
    x_mm, y_mm = np.moveaxis(pixel_centres(target.bounds_mm), -1, 0)
    lowest, highest = float(np.nanmin(target.z_mm)), float(np.nanmax(target.z_mm))
    reference = grey_image(depth, lowest, highest)
    print("| error | `ssim_eq4` | `ssim_eq4_own_scale` | `ssim_gauss` | RMS of height mm |\n|---|---|---|---|---|")
    for name, wrong in errors_mm(depth, x_mm, y_mm).items():
        sample = grey_image(wrong, lowest, highest)
        indices = (ssim_eq4(reference, sample), ssim_eq4_own_scale(reference, sample), ssim_gauss(reference, sample))
        rms = float(np.sqrt(np.nanmean((wrong - depth) ** 2)))
        print(f"| {name} | {' | '.join(f'{index:.3f}' for index in indices)} | {rms:.2f} |")


if __name__ == "__main__":
    main()
