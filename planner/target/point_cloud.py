"""Heights from point clouds as scanners give them: noisy, uneven, with outliers."""

from pathlib import Path

import numpy as np
from scipy import ndimage
from scipy.spatial import KDTree

from planner.errors import InputError
from planner.target.local_planes import LocalPlanes, local_planes
from planner.target.mesh_heights import GridHeights, even_grid

FEWEST_POINTS = 200
"""Fewest points of a cloud: about ten along each side of an oval."""
NEIGHBOURS = 8
"""Neighbours that tell a point's local spacing."""
LONELY = 4.0
"""A point this many times farther from its neighbours than they are from theirs is an outlier."""
WINDOW_SPACINGS = 1.2
"""Standard deviation of the narrowest window [point spacings]: about 18 points share in each height."""
ENOUGH_SUPPORT = 4.0
"""Sum of weights from which a window is trusted; elsewhere the next one, twice as wide, is used."""
OUTLYING = 5.0
"""Distance from the surface beyond which a point is an outlier [standard deviations of the noise]."""
OUTLIER_SHARE = 0.10
"""Largest share of outliers; more, and the cloud is no single sheet."""
THICKNESS_SHARE = 0.03
"""Largest standard deviation of the heights around the surface, as a share of the size."""
MARGIN_CELLS = 6
"""Empty cells around the cloud, room for its footprint."""


def read_xyz(path: Path, *, name: str) -> np.ndarray:
    """Read a text file of points: x, y, z in the first three columns, more columns are ignored.

    Raises:
        InputError: A line does not hold three numbers.
    """
    points = []
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    for number, line in enumerate(lines, start=1):
        words = line.partition("#")[0].replace(",", " ").replace(";", " ").split()
        if not words:
            continue
        try:
            x, y, z = (float(word) for word in words[:3])
        except ValueError:
            raise InputError(
                f"{name}: line {number} of {path} is {line.strip()[:40]!r}; each line needs three numbers, x y z."
            ) from None
        points.append((x, y, z))
    return np.array(points, dtype=float).reshape(-1, 3)


def clean_cloud(points: np.ndarray, *, name: str) -> tuple[np.ndarray, tuple[str, ...]]:
    """Drop points that are no numbers, doubled, or far from all others; shape [n, 3], and notes.

    Raises:
        InputError: Too few points are left.
    """
    finite = points[np.isfinite(points).all(axis=1)]
    cloud = np.unique(finite, axis=0)
    notes = []
    if len(finite) < len(points):
        notes.append(f"{len(points) - len(finite)} points that are NaN or infinite were dropped.")
    if len(cloud) > NEIGHBOURS:
        distances, neighbours = KDTree(cloud).query(cloud, k=NEIGHBOURS + 1)
        reach = np.asarray(distances)[:, 1:].mean(axis=1)
        lonely = reach > LONELY * np.median(reach[np.asarray(neighbours)[:, 1:]], axis=1)
        if lonely.any():
            notes.append(f"{lonely.sum()} points far from all others were dropped.")
        cloud = cloud[~lonely]
    if len(cloud) < FEWEST_POINTS:
        raise InputError(
            f"{name}: the cloud has {len(cloud)} usable points of {len(points)}; at least {FEWEST_POINTS} are "
            "needed: scan more densely, or give a mesh."
        )
    return cloud, tuple(notes)


def cloud_heights(cloud: np.ndarray, *, name: str) -> GridHeights:
    """Fit a surface through a cloud on a grid, by local planes as wide as the density asks for.

    Args:
        cloud: Cleaned points [mm], z up, shape [n, 3].
        name: Named in messages.

    Raises:
        InputError: The points do not form a single sheet seen from above.
    """
    distances = np.asarray(KDTree(cloud[:, :2]).query(cloud[:, :2], k=NEIGHBOURS + 1)[0])
    # k points lie within a radius r at density k / (pi r^2).
    spacing = distances[:, -1] * np.sqrt(np.pi / NEIGHBOURS)
    typical, sparse = float(np.median(spacing)), float(np.percentile(spacing, 95))
    low, high = cloud.min(axis=0), cloud.max(axis=0)
    x, y = even_grid(low, high, 0.5 * typical)
    steps = np.array([x[1] - x[0], y[1] - y[0]])
    x, y = (
        axis[0] + step * np.arange(-MARGIN_CELLS, len(axis) + MARGIN_CELLS)
        for axis, step in zip((x, y), steps, strict=True)
    )

    kept = np.ones(len(cloud), dtype=bool)
    for _ in range(3):
        planes = _fit(cloud[kept], x, y, WINDOW_SPACINGS * typical)
        offset = cloud[:, 2] - _height_at(planes, cloud, x, y)
        noise = 1.4826 * float(np.median(np.abs(offset[kept])))
        kept = np.abs(offset) <= max(OUTLYING * noise, 0.05 * typical)
    size = float((high - low)[:2].max())
    share = 1.0 - kept.mean()
    if noise > THICKNESS_SHARE * size or share > OUTLIER_SHARE:
        raise InputError(
            f"{name}: seen from above the points do not form one sheet: {share:.0%} of them lie off the fitted "
            f"surface, the others scatter by {noise:.2g} mm around it; allowed are {OUTLIER_SHARE:.0%} and "
            f"{THICKNESS_SHARE * size:.2g} mm: remove the back side, or turn the cloud (--up)."
        )
    notes = [f"A surface was fitted through {kept.sum()} points; they scatter by {noise:.2g} mm around it."]
    if share > 0:
        notes.append(f"{(~kept).sum()} points off that surface were dropped.")
    inside = _footprint(cloud[kept], x, y, 2.0 * sparse)
    return GridHeights(x_mm=x, y_mm=y, z_mm=np.where(inside, planes.value_mm, np.nan), notes=tuple(notes))


def _fit(cloud: np.ndarray, x: np.ndarray, y: np.ndarray, sigma_mm: float) -> LocalPlanes:
    """Fit planes around all nodes, each by the narrowest window that sees enough points."""
    column, row = _cells(cloud, x, y)
    shape = (len(y), len(x))
    node = row * shape[1] + column
    count = np.bincount(node, minlength=shape[0] * shape[1]).reshape(shape).astype(float)
    total = np.bincount(node, cloud[:, 2], minlength=shape[0] * shape[1]).reshape(shape)
    heights = total / np.maximum(count, 1.0)
    spacing = (float(x[1] - x[0]), float(y[1] - y[0]))
    widest = max(np.ptp(x), np.ptp(y))
    result = local_planes(heights, count, spacing_mm=spacing, sigma_mm=sigma_mm)
    covered = np.asarray(ndimage.binary_closing(count > 0, iterations=2))
    while (result.support[covered] < ENOUGH_SUPPORT).any() and sigma_mm < widest:
        sigma_mm *= 2.0
        wider = local_planes(heights, count, spacing_mm=spacing, sigma_mm=sigma_mm)
        thin = result.support < ENOUGH_SUPPORT
        result = LocalPlanes(
            value_mm=np.where(thin, wider.value_mm, result.value_mm),
            slope_x=np.where(thin, wider.slope_x, result.slope_x),
            slope_y=np.where(thin, wider.slope_y, result.slope_y),
            support=np.where(thin, wider.support, result.support),
        )
    return result


def _height_at(planes: LocalPlanes, cloud: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Height of the fitted surface at the points of a cloud [mm], shape [n]."""
    column, row = _cells(cloud, x, y)
    rise = planes.slope_x[row, column] * (cloud[:, 0] - x[column])
    rise += planes.slope_y[row, column] * (cloud[:, 1] - y[row])
    return planes.value_mm[row, column] + rise


def _cells(cloud: np.ndarray, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nearest grid column and row of each point."""
    column = np.clip(np.round((cloud[:, 0] - x[0]) / (x[1] - x[0])).astype(int), 0, len(x) - 1)
    row = np.clip(np.round((cloud[:, 1] - y[0]) / (y[1] - y[0])).astype(int), 0, len(y) - 1)
    return column, row


def _footprint(cloud: np.ndarray, x: np.ndarray, y: np.ndarray, reach_mm: float) -> np.ndarray:
    """Region that the points cover, gaps narrower than twice the reach closed; shape [ny, nx], bool."""
    steps = (float(y[1] - y[0]), float(x[1] - x[0]))
    margin = int(np.ceil(reach_mm / min(steps))) + 1
    taken = np.zeros((len(y), len(x)), dtype=bool)
    column, row = _cells(cloud, x, y)
    taken[row, column] = True
    taken = np.pad(taken, margin)
    grown = np.asarray(ndimage.distance_transform_edt(~taken, sampling=steps)) <= reach_mm
    closed = np.asarray(ndimage.distance_transform_edt(grown, sampling=steps)) > reach_mm
    return closed[margin:-margin, margin:-margin]
