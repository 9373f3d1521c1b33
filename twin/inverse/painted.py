"""What each triangle remembers of a layer's passes, as a linear map of the contraction along them.

With the passes' paths fixed, painting, blur and averaging are linear: the alignment vector of a triangle is a weighted
sum of e (cos 2 theta, sin 2 theta) over the segments that cross it. The same steps as `twin.film.raster`, as matrices.
"""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from scipy.ndimage import gaussian_filter1d

from planner.calibration import Calibration
from planner.program import Pass
from twin.film.build import inner_points
from twin.film.options import FilmOptions
from twin.film.raster import PIXEL_MM, follow_passes


def painted_layer(
    passes: Sequence[Pass],
    calibration: Calibration,
    corners_mm: np.ndarray,
    bounds_mm: tuple[np.ndarray, np.ndarray],
    options: FilmOptions,
    line_width_mm: float,
) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """Return the maps from the contraction of each segment to both components of the triangles' alignment vectors.

    Args:
        passes: the layer's passes; their loads and speeds do not matter.
        calibration: only for its limits.
        corners_mm: corners of the film's triangles [mm], shape [m, 3, 2].
        bounds_mm: lower left and upper right corner of the painted region [mm].
        options: blur and end length of the post.
        line_width_mm: width of the scratched line [mm].

    Returns:
        Two matrices, shape [m, segments].
    """
    count = sum(len(stroke.speed_mm_s) for stroke in passes)
    if not count:
        empty = sp.csr_matrix((len(corners_mm), 0))
        return empty, empty
    strokes = follow_passes(
        passes, calibration, bounds_mm, line_width_mm=line_width_mm, end_length_mm=options.end_length_mm
    )
    shape = strokes.owner.shape
    pixel = np.flatnonzero(strokes.owner.ravel() >= 0)
    piece = strokes.owner.ravel()[pixel]
    blur_x = sp.kron(sp.identity(shape[0]), _blur(shape[1], options.edge_blur_mm), format="csr")
    blur_y = sp.kron(_blur(shape[0], options.edge_blur_mm), sp.identity(shape[1]), format="csr")
    average = _average(inner_points(corners_mm), strokes.origin_mm, shape) @ blur_y @ blur_x
    maps = [
        sp.csr_matrix(
            (strokes.director[piece, part], (pixel, strokes.segment[piece])), shape=(shape[0] * shape[1], count)
        )
        for part in range(2)
    ]
    return (average @ maps[0]).tocsr(), (average @ maps[1]).tocsr()


def _blur(size: int, blur_mm: float) -> sp.csr_matrix:
    """Return the Gaussian filter along one axis as a matrix."""
    if blur_mm <= 0.0:
        return sp.csr_matrix(sp.identity(size))
    reach = int(4.0 * blur_mm / PIXEL_MM + 0.5)
    impulse = np.zeros(2 * reach + 1)
    impulse[reach] = 1.0
    kernel = gaussian_filter1d(impulse, blur_mm / PIXEL_MM, mode="constant")
    bands = np.tile(kernel[:, None], size)
    return sp.csr_matrix(sp.dia_matrix((bands, np.arange(-reach, reach + 1)), shape=(size, size)))


def _average(points_mm: np.ndarray, origin_mm: np.ndarray, shape: tuple[int, ...]) -> sp.csr_matrix:
    """Return the mean over each triangle's points [m, points, 2] of the bilinear interpolation of pixels."""
    place = (points_mm - origin_mm) / PIXEL_MM
    first = np.floor(place).astype(int)
    part = place - first
    rows, columns, values = [], [], []
    triangle = np.broadcast_to(np.arange(len(place))[:, None], place.shape[:2])
    for right in range(2):
        for up in range(2):
            column, row = first[..., 0] + right, first[..., 1] + up
            weight = np.abs(1.0 - right - part[..., 0]) * np.abs(1.0 - up - part[..., 1])
            inside = (column >= 0) & (column < shape[1]) & (row >= 0) & (row < shape[0])
            rows.append(triangle[inside])
            columns.append((row * shape[1] + column)[inside])
            values.append(weight[inside] / place.shape[1])
    return sp.csr_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
        shape=(len(place), shape[0] * shape[1]),
    )
