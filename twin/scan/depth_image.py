"""Depth images: a surface seen straight from above, one height per pixel."""

from collections.abc import Iterator

import numpy as np

from planner.target import Surface, Target

SHAPE_PX = (104, 168)
"""Width and height of the paper's grey images [px] (section 2.4)."""

_PAIRS_AT_ONCE = 4_000_000
"""Triangle-pixel pairs tested in one go; bounds the memory for huge triangles to some 300 MB."""


def depth_image(
    vertices: np.ndarray,
    triangles: np.ndarray,
    bounds: tuple[np.ndarray, np.ndarray],
    shape_px: tuple[int, int] = SHAPE_PX,
) -> np.ndarray:
    """See a triangulated surface from above: the topmost height at each pixel's centre.

    ::

        row 0    +y   low[0] .. high[0] = columns, low[1] .. high[1] = rows from the bottom up
          :
        row h-1  -y   the box is cut into w x h equal pixels; what lies outside of it is not seen

    Args:
        vertices: Vertices [mm], z up, shape [n, 3], float.
        triangles: Vertex indices in any orientation, shape [m, 3], int.
        bounds: Lower left and upper right corner of the box [mm], each shape [2].
        shape_px: Width and height of the image [px].

    Returns:
        Heights [mm], NaN where no surface is, shape [height, width], float.
    """
    width, height = shape_px
    image = np.full(width * height, -np.inf)
    for pixel, _, _, z in _hits(vertices, triangles, bounds, shape_px):
        np.maximum.at(image, pixel, z)
    image[np.isinf(image)] = np.nan
    return image.reshape(height, width)[::-1]


def target_depth_image(target: Target, shape_px: tuple[int, int] = SHAPE_PX) -> np.ndarray:
    """See a target from above over its own bounding box: bilinear heights [mm], NaN outside, [height, width]."""
    return Surface(target).height(pixel_centres(target.bounds_mm, shape_px))


def pixel_centres(bounds: tuple[np.ndarray, np.ndarray], shape_px: tuple[int, int] = SHAPE_PX) -> np.ndarray:
    """X and y of each pixel's centre [mm], rows from the top (+y) to the bottom, shape [height, width, 2]."""
    (x0, y0), (x1, y1) = bounds
    width, height = shape_px
    x = x0 + (np.arange(width) + 0.5) * (x1 - x0) / width
    y = y1 - (np.arange(height) + 0.5) * (y1 - y0) / height
    return np.stack(np.meshgrid(x, y), axis=-1)


def grey_image(depth_mm: np.ndarray, lowest_mm: float, highest_mm: float) -> np.ndarray:
    """Map heights to grey: `lowest_mm` to 1, `highest_mm` to 255, NaN to 0, beyond them linear, never clipped."""
    grey = 1.0 + 254.0 * (depth_mm - lowest_mm) / (highest_mm - lowest_mm)
    return np.where(np.isnan(depth_mm), 0.0, grey)


def pixel_weights(
    vertices: np.ndarray,
    triangles: np.ndarray,
    bounds: tuple[np.ndarray, np.ndarray],
    shape_px: tuple[int, int] = SHAPE_PX,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Find what each pixel of `depth_image` sees: arguments as there.

    Returns:
        Pixels that see the surface, as row * width + column, ascending, shape [k]; the topmost triangle at each,
        shape [k]; and the barycentric weights of its corners there, shape [k, 3].
    """
    width, height = shape_px
    pixel, triangle, weights, z = (
        np.concatenate(parts) for parts in zip(*_hits(vertices, triangles, bounds, shape_px), strict=True)
    )
    pixel = (height - 1 - pixel // width) * width + pixel % width
    order = np.lexsort((z, pixel))
    top = order[np.append(np.diff(pixel[order]) > 0, True)] if len(order) else order
    return pixel[top], triangle[top], weights[top]


def _hits(
    vertices: np.ndarray, triangles: np.ndarray, bounds: tuple[np.ndarray, np.ndarray], shape_px: tuple[int, int]
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Yield, part by part, every pixel and triangle that covers its centre, with corner weights and height.

    Pixels count row by row from the bottom.
    """
    width, height = shape_px
    low, high = np.asarray(bounds[0], dtype=float), np.asarray(bounds[1], dtype=float)
    pixel = (high - low) / (width, height)
    corners = np.asarray(vertices, dtype=float)[np.asarray(triangles)]
    # From here on x and y count pixels, with pixel centres at whole numbers.
    xy = (corners[:, :, :2] - low) / pixel - 0.5
    first = np.clip(np.ceil(xy.min(axis=1) - 1e-9), 0, (width, height)).astype(np.int64)
    last = np.clip(np.floor(xy.max(axis=1) + 1e-9), -1, (width - 1, height - 1)).astype(np.int64)
    extent = np.maximum(last - first + 1, 0)
    ends = np.cumsum(extent[:, 0] * extent[:, 1])
    start = 0
    while start < len(ends):
        done = ends[start - 1] if start else 0
        stop = max(int(np.searchsorted(ends, done + _PAIRS_AT_ONCE, side="right")), start + 1)
        part = slice(start, stop)
        where, which, weights = _inside(width, xy[part], first[part], extent[part])
        yield where, which + start, weights, (weights * corners[which + start, :, 2]).sum(axis=1)
        start = stop


def _inside(
    width: int, xy: np.ndarray, first: np.ndarray, extent: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return pixels inside the triangles `xy` [m, 3, 2], the triangle of each and its corner weights [k, 3]."""
    count = extent[:, 0] * extent[:, 1]
    which = np.repeat(np.arange(len(count)), count)
    within = np.arange(which.size) - np.repeat(np.cumsum(count) - count, count)
    across = np.maximum(extent[which, 0], 1)
    column, row = first[which, 0] + within % across, first[which, 1] + within // across
    a, b, c = xy[:, 0], xy[:, 1], xy[:, 2]
    double_area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    # A triangle seen edge-on covers nothing; its neighbours show what is there.
    safe = np.where(np.abs(double_area) > 1e-12, double_area, np.inf)[which]
    dx, dy = column - a[which, 0], row - a[which, 1]
    weight_b = (dx * (c - a)[which, 1] - dy * (c - a)[which, 0]) / safe
    weight_c = (dy * (b - a)[which, 0] - dx * (b - a)[which, 1]) / safe
    weights = np.stack((1.0 - weight_b - weight_c, weight_b, weight_c), axis=1)
    # The slack keeps pixel centres that lie on a shared edge from falling between two triangles.
    hit = np.isfinite(safe) & (weights.min(axis=1) >= -1e-9)
    return (row * width + column)[hit], which[hit], weights[hit]
