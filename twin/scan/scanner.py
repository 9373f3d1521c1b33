"""The virtual scanner: a shape as a phone's depth camera would see it."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter

from twin.scan.closest import grid_triangles
from twin.scan.depth_image import depth_image, pixel_centres
from twin.scan.scan import Scan


@dataclass(frozen=True, kw_only=True)
class Scanner:
    """Error model of a depth camera: a smooth bias and noise in each pixel."""

    pixel_mm: float = 0.4
    """Distance between depth pixels [mm]."""
    bias_rms_mm: float = 0.4
    """Root mean square of the smooth bias of height over the surface [mm]."""
    correlation_mm: float = 7.0
    """Distance over which the bias stays alike: its autocorrelation has fallen to 1/e there [mm]."""
    noise_rms_mm: float = 0.15
    """Root mean square of the independent noise of each pixel [mm]."""

    def scan(self, vertices_mm: np.ndarray, triangles: np.ndarray, rng: np.random.Generator) -> Scan:
        """Look at a surface from above and return the noisy height grid as triangles.

        Args:
            vertices_mm: Vertices [mm], z up, shape [n, 3], float.
            triangles: Vertex indices, shape [m, 3], int.
            rng: Source of the errors.
        """
        low, high = vertices_mm[:, :2].min(axis=0), vertices_mm[:, :2].max(axis=0)
        width, height = (int(n) for n in np.maximum(np.ceil((high - low) / self.pixel_mm), 2))
        bounds = low, low + self.pixel_mm * np.array([width, height])
        image = depth_image(vertices_mm, triangles, bounds, (width, height))
        xy = pixel_centres(bounds, (width, height))
        seen = image + self.errors(image.shape, rng)
        vertices, faces = grid_triangles(xy[0, :, 0], xy[::-1, 0, 1], seen[::-1])
        return Scan(vertices_mm=vertices, triangles=faces)

    def errors(self, shape_px: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
        """Draw one field of height errors [mm], shape [rows, columns]."""
        # White noise through a Gaussian of sigma s has the autocorrelation exp(-d^2 / (4 s^2)): 1/e at d = 2 s.
        sigma = self.correlation_mm / 2.0 / self.pixel_mm
        margin = int(np.ceil(3 * sigma))
        white = rng.standard_normal((shape_px[0] + 2 * margin, shape_px[1] + 2 * margin))
        smooth = gaussian_filter(white, sigma)
        # Filtered white noise has the variance 1 / (4 pi s^2): the ensemble, not this one draw, has the set rms.
        bias = smooth[margin:-margin, margin:-margin] * (2.0 * np.sqrt(np.pi) * sigma) * self.bias_rms_mm
        return bias + self.noise_rms_mm * rng.standard_normal(shape_px)
