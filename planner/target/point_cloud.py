"""Heights from point clouds as scanners give them: noisy, uneven, with outliers."""

from pathlib import Path

import numpy as np
from scipy import ndimage
from scipy.spatial import KDTree

from planner.errors import InputError
from planner.target.local_planes import LocalPlanes, local_planes
from planner.target.mesh_heights import GRID_MM, GridHeights, even_grid

FEWEST_POINTS = 200
"""Fewest points of a cloud: about ten along each side of an oval."""
NEIGHBOURS = 8
"""Neighbours that tell a point's local spacing."""
LONELY = 4.0
"""A point this many times farther from its neighbours than they are from theirs is an outlier."""
DESOLATE = 8.0
"""So is a point this many times farther from its neighbours than usual: outliers can be each other's company."""
WINDOW_SPACINGS = 1.2
"""Standard deviation of the narrowest window [point spacings]: about 18 points share in each height."""
WIDEST_WINDOW_MM = 1.0
"""Noise widens the window no further than this [mm], half the distance of neighbours in Eq. 1."""
CALM_MM = 0.03
"""Noise of the fitted heights that the window is widened for [mm]."""
WINDOW_OCTAVES = 3
"""Windows of once, twice, four times the width; where points are sparse the wider ones take over."""
SUPPORT_RANGE = (3.0, 9.0)
"""Sum of weights below which a window counts nothing, and above which it needs no wider one."""
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
    try:
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as error:
        raise InputError(f"{name}: {path} cannot be read ({error.strerror}); check its permissions.") from error
    points = []
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
    lonely = _lonely(cloud)
    before = len(cloud)
    while lonely.any():
        cloud = cloud[~lonely]
        lonely = _lonely(cloud)
    if len(cloud) < before:
        notes.append(f"{before - len(cloud)} points far from all others were dropped.")
    if len(cloud) < FEWEST_POINTS:
        raise InputError(
            f"{name}: the cloud has {len(cloud)} usable points of {len(points)}; at least {FEWEST_POINTS} are "
            "needed: scan more densely, or give a mesh."
        )
    return cloud, tuple(notes)


def _lonely(cloud: np.ndarray) -> np.ndarray:
    """Tell which points are far from their neighbours, for that place or for the whole cloud; shape [n], bool."""
    if len(cloud) <= NEIGHBOURS:
        return np.zeros(len(cloud), dtype=bool)
    distances, neighbours = KDTree(cloud).query(cloud, k=NEIGHBOURS + 1)
    reach = np.asarray(distances)[:, 1:].mean(axis=1)
    around = np.median(reach[np.asarray(neighbours)[:, 1:]], axis=1)
    return reach > np.minimum(LONELY * around, DESOLATE * np.median(reach))


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
    x, y = even_grid(low, high, max(GRID_MM, 0.5 * typical))
    steps = np.array([x[1] - x[0], y[1] - y[0]])
    x, y = (
        axis[0] + step * np.arange(-MARGIN_CELLS, len(axis) + MARGIN_CELLS)
        for axis, step in zip((x, y), steps, strict=True)
    )

    kept, window = np.ones(len(cloud), dtype=bool), WINDOW_SPACINGS * typical
    for _ in range(3):
        planes = _fit(cloud[kept], x, y, window)
        offset = _offsets(planes, cloud, x, y)
        noise = 1.4826 * float(np.median(np.abs(offset[kept])))
        kept = np.abs(offset) <= max(OUTLYING * noise, 0.05 * typical)
        # A Gaussian window of width s averages over 4 pi s^2 times the density of points.
        calming = typical * noise / CALM_MM / np.sqrt(4.0 * np.pi)
        window = max(WINDOW_SPACINGS * typical, min(calming, WIDEST_WINDOW_MM))
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
    inside = _footprint(cloud, x, y, sparse) & np.isfinite(planes.value_mm)
    return GridHeights(x_mm=x, y_mm=y, z_mm=np.where(inside, planes.value_mm, np.nan), notes=tuple(notes))


def _fit(cloud: np.ndarray, x: np.ndarray, y: np.ndarray, sigma_mm: float) -> LocalPlanes:
    """Fit planes around all nodes, by windows that are wider where points are sparse."""
    column, row = _cells(cloud, x, y)
    shape = (len(y), len(x))
    node = row * shape[1] + column
    count = np.bincount(node, minlength=shape[0] * shape[1]).reshape(shape).astype(float)
    total = np.bincount(node, cloud[:, 2], minlength=shape[0] * shape[1]).reshape(shape)
    heights = total / np.maximum(count, 1.0)
    spacing = (float(x[1] - x[0]), float(y[1] - y[0]))
    octaves = [
        local_planes(heights, count, spacing_mm=spacing, sigma_mm=sigma_mm * 2.0**octave)
        for octave in reversed(range(WINDOW_OCTAVES))
    ]
    result = octaves[0]
    for finer in octaves[1:]:
        # A sudden change of window would leave a step in the surface.
        low, high = SUPPORT_RANGE
        trust = np.clip((finer.support - low) / (high - low), 0.0, 1.0)
        result = LocalPlanes(
            value_mm=_blend(result.value_mm, finer.value_mm, trust),
            slope_x=_blend(result.slope_x, finer.slope_x, trust),
            slope_y=_blend(result.slope_y, finer.slope_y, trust),
            support=np.maximum(result.support, finer.support),
        )
    return result


def _blend(coarse: np.ndarray, fine: np.ndarray, trust: np.ndarray) -> np.ndarray:
    return np.where(trust > 0, trust * np.where(trust > 0, fine, 0.0) + (1.0 - trust) * coarse, coarse)


def _offsets(planes: LocalPlanes, cloud: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Distance of the points of a cloud to the plane at their node [mm], positive above, shape [n]."""
    column, row = _cells(cloud, x, y)
    slope_x, slope_y = planes.slope_x[row, column], planes.slope_y[row, column]
    plane = planes.value_mm[row, column]
    plane = plane + slope_x * (cloud[:, 0] - x[column]) + slope_y * (cloud[:, 1] - y[row])
    return (cloud[:, 2] - plane) / np.sqrt(1.0 + slope_x**2 + slope_y**2)


def _cells(cloud: np.ndarray, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nearest grid column and row of each point."""
    column = np.clip(np.round((cloud[:, 0] - x[0]) / (x[1] - x[0])).astype(int), 0, len(x) - 1)
    row = np.clip(np.round((cloud[:, 1] - y[0]) / (y[1] - y[0])).astype(int), 0, len(y) - 1)
    return column, row


def _footprint(cloud: np.ndarray, x: np.ndarray, y: np.ndarray, spacing_mm: float) -> np.ndarray:
    """Region that the points cover, gaps up to four spacings closed and the border smoothed; shape [ny, nx]."""
    steps = (float(y[1] - y[0]), float(x[1] - x[0]))
    reach = 2.0 * spacing_mm
    margin = int(np.ceil(reach / min(steps))) + 1
    taken = np.zeros((len(y), len(x)), dtype=bool)
    column, row = _cells(cloud, x, y)
    taken[row, column] = True
    taken = np.pad(taken, margin)
    grown = np.asarray(ndimage.distance_transform_edt(~taken, sampling=steps)) <= reach
    closed = np.asarray(ndimage.distance_transform_edt(grown, sampling=steps)) > reach
    smooth = ndimage.gaussian_filter(closed.astype(float), [spacing_mm / step for step in steps])
    return smooth[margin:-margin, margin:-margin] > 0.5
