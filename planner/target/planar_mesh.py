"""Well-shaped triangle meshes of flat outlines."""

from collections.abc import Sequence

import numpy as np
import shapely
from scipy.spatial import Delaunay, KDTree

from planner.errors import InputError
from planner.target.outline import loop_length, resample_loop, signed_area

CORNER_RAD = np.deg2rad(40.0)
"""Turns of the outline sharper than this within one edge length stay vertices of the mesh [rad]."""
CLEARANCE_EDGES = 0.65
"""Distance of the lattice from the border [edges]; above 0.5, so that border edges are Delaunay edges."""
BAND_EDGES = 4.0
"""Width of the band along the border in which the lattice yields to it [edges]."""
RELAXATIONS = 4
"""Rounds of relaxation in the band; more change the angles by less than a degree."""
SPLITS = 6
"""How often missing border edges are halved before the outline is given up as too narrow."""
EAR_RAD = np.deg2rad(15.0)
"""Smallest angle that cutting off an ear may leave [rad]."""


def mesh_outline(
    outline_mm: np.ndarray, edge_mm: float, holes: Sequence[np.ndarray] = ()
) -> tuple[np.ndarray, np.ndarray]:
    """Triangulate a flat region with edges close to one length.

    A hexagonal lattice fills the region, the border is sampled at the edge length with its corners kept, and
    lattice points near the border move to the centroids of their surroundings (the centroidal patch scheme of
    Chen and Holst 2011, doi:10.1016/j.cma.2010.11.007). The mesh depends on nothing but the arguments.

    Args:
        outline_mm: Closed outline [mm], first point not repeated, shape [n, 2].
        edge_mm: Wanted edge length [mm].
        holes: Closed outlines of holes [mm], each shape [k, 2].

    Returns:
        Points [mm], shape [p, 2], those of the border first, and triangles, counter-clockwise, shape [m, 3].

    Raises:
        InputError: The edge length is not positive, or the region is too narrow for it.
    """
    if not (np.isfinite(edge_mm) and edge_mm > 0):
        raise InputError(f"mesh: the edge length is {edge_mm} mm; give a positive length, for example 0.6.")
    loops = [_oriented(loop, 1.0) for loop in (outline_mm,)] + [_oriented(loop, -1.0) for loop in holes]
    borders = [_sample_border(loop, edge_mm) for loop in loops]
    for _ in range(SPLITS):
        region = shapely.Polygon(borders[0], borders[1:])
        if not region.is_valid:
            break
        points, triangles = _fill(borders, region, edge_mm)
        missing = _missing_border_edges(borders, triangles)
        if not any(edges.any() for edges in missing):
            return points, _cut_ears(points, triangles, sum(map(len, borders)))
        borders = [_halve(loop, edges) for loop, edges in zip(borders, missing, strict=True)]
    raise InputError(
        f"mesh: parts of the outline are narrower than the edge length of {edge_mm:g} mm; choose shorter edges."
    )


def _oriented(loop: np.ndarray, sign: float) -> np.ndarray:
    loop = np.asarray(loop, dtype=float)
    return loop if signed_area(loop) * sign > 0 else loop[::-1]


def _sample_border(loop: np.ndarray, edge: float) -> np.ndarray:
    """Sample a closed line at the edge length, corners kept; shape [n, 2]."""
    half = 8
    fine = resample_loop(loop, max(6 * half, round(loop_length(loop) / edge * 2 * half)))
    ahead, behind = np.roll(fine, -half, axis=0) - fine, fine - np.roll(fine, half, axis=0)
    cross = behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0]
    turn = np.abs(np.arctan2(cross, np.einsum("ij,ij->i", behind, ahead)))
    window = np.stack([np.roll(turn, shift) for shift in range(-2 * half, 2 * half + 1)])
    # Ties (a perfectly sharp corner between two samples) go to the first one.
    first = window[: 2 * half].max(axis=0) <= turn
    corners = np.flatnonzero((turn > CORNER_RAD) & first & (window[2 * half + 1 :].max(axis=0) < turn))
    if corners.size == 0:
        return resample_loop(fine, max(6, round(loop_length(fine) / edge)))
    sharp = fine.copy()
    # A corner is where the loop's own vertex lies, when one is near.
    gap, own = KDTree(loop).query(fine[corners])
    near = np.asarray(gap) < edge / half
    sharp[corners[near]] = loop[np.asarray(own)[near]]
    pieces = []
    for start, end in zip(corners, np.roll(corners, -1), strict=True):
        span = np.arange(start, end + 1 if end > start else end + len(sharp) + 1) % len(sharp)
        line = sharp[span]
        arc = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))))
        parts = max(2 if corners.size < 3 else 1, round(arc[-1] / edge))
        at = arc[-1] * np.arange(parts) / parts
        pieces.append(np.column_stack((np.interp(at, arc, line[:, 0]), np.interp(at, arc, line[:, 1]))))
    return np.vstack(pieces)


def _fill(borders: list[np.ndarray], region: shapely.Polygon, edge: float) -> tuple[np.ndarray, np.ndarray]:
    """Fill a region with lattice points, relax those near the border, and triangulate."""
    shapely.prepare(region)
    border = np.vstack(borders)
    lattice = _lattice(border, edge)
    lattice = lattice[shapely.contains_xy(region, lattice[:, 0], lattice[:, 1])]
    dense = np.vstack([resample_loop(loop, 8 * len(loop)) for loop in borders])
    distance = KDTree(dense).query(lattice, distance_upper_bound=BAND_EDGES * edge)[0]
    clear = distance > CLEARANCE_EDGES * edge
    points = np.vstack((border, lattice[clear]))
    movable = len(border) + np.flatnonzero(distance[clear] < BAND_EDGES * edge)
    for _ in range(RELAXATIONS):
        triangles, areas = _delaunay(points, region, edge)
        centroids = points[triangles].mean(axis=1)
        corners = triangles.ravel()
        total = np.bincount(corners, np.repeat(areas, 3), len(points))
        for axis in (0, 1):
            moment = np.bincount(corners, np.repeat(areas * centroids[:, axis], 3), len(points))
            points[movable, axis] = moment[movable] / total[movable]
    return points, _delaunay(points, region, edge)[0]


def _lattice(border: np.ndarray, edge: float) -> np.ndarray:
    """Hexagonal lattice around the middle of the border's bounding box, shape [n, 2]."""
    low, high = border.min(axis=0), border.max(axis=0)
    rise = edge * np.sqrt(3.0) / 2.0
    columns, rows = (int(np.ceil(0.5 * span / step)) + 1 for span, step in zip(high - low, (edge, rise), strict=True))
    row, column = np.mgrid[-rows : rows + 1, -columns : columns + 1]
    offsets = np.column_stack(((edge * (column + 0.5 * (row % 2))).ravel(), (rise * row).ravel()))
    return 0.5 * (low + high) + offsets


def _delaunay(points: np.ndarray, region: shapely.Polygon, edge: float) -> tuple[np.ndarray, np.ndarray]:
    """Counter-clockwise Delaunay triangles inside a region, shape [m, 3], and their areas, shape [m]."""
    triangles = Delaunay(points).simplices.astype(np.int64)
    areas = _areas(points, triangles)
    triangles = np.where(areas[:, None] < 0, triangles[:, ::-1], triangles)
    areas = np.abs(areas)
    centroids = points[triangles].mean(axis=1)
    # Three neighbours on a straight border make a triangle without area, on either side by rounding.
    kept = (areas > 1e-4 * edge**2) & shapely.contains_xy(region, centroids[:, 0], centroids[:, 1])
    return triangles[kept], areas[kept]


def _areas(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    first, second = (points[triangles[:, k]] - points[triangles[:, 0]] for k in (1, 2))
    return 0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])


def _missing_border_edges(borders: list[np.ndarray], triangles: np.ndarray) -> list[np.ndarray]:
    """For each border loop, which of its edges no triangle has, each shape [n], bool."""
    count = sum(map(len, borders))
    directed = np.vstack((triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]))
    directed = directed[(directed < count).all(axis=1)]
    present = np.unique(directed[:, 0] * count + directed[:, 1])
    missing, start = [], 0
    for loop in borders:
        index = start + np.arange(len(loop))
        missing.append(~np.isin(index * count + np.roll(index, -1), present))
        start += len(loop)
    return missing


def _halve(loop: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Insert the midpoints of some edges of a loop."""
    index = np.flatnonzero(edges)
    return np.insert(loop, index + 1, 0.5 * (loop[index] + loop[(index + 1) % len(loop)]), axis=0)


def _cut_ears(points: np.ndarray, triangles: np.ndarray, border_count: int) -> np.ndarray:
    r"""Swap the diagonal under triangles that hang on a single edge: all their corners lie on the border.

    Such an ear can neither stretch nor bend freely; after the swap its tip has an edge into the inside.

            tip                 tip
           /   \               / | \
          a ----- b    ->      a  |  b
           \   /               \ | /
            far                 far
    """
    triangles = triangles.copy()
    for ear in np.flatnonzero((triangles < border_count).all(axis=1)):
        a, b, c = triangles[ear]
        for tip, left, right in ((a, b, c), (b, c, a), (c, a, b)):
            # The other triangle has the edge left -> right in the opposite sense.
            other, far = _across(triangles, right, left)
            if other < 0 or far < border_count:
                continue
            swapped = np.array([[tip, left, far], [tip, far, right]])
            if _smallest_angle(points, swapped) > EAR_RAD:
                triangles[[ear, other]] = swapped
                break
    return triangles


def _across(triangles: np.ndarray, start: int, end: int) -> tuple[int, int]:
    """Find the triangle with a directed edge, and its third corner; (-1, -1) when there is none."""
    for k in range(3):
        hits = np.flatnonzero((triangles[:, k] == start) & (triangles[:, (k + 1) % 3] == end))
        if hits.size:
            return int(hits[0]), int(triangles[hits[0], (k + 2) % 3])
    return -1, -1


def _smallest_angle(points: np.ndarray, triangles: np.ndarray) -> float:
    """Smallest angle of some triangles [rad], negative if one is turned over."""
    corners = points[triangles]
    ahead, behind = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    cross = ahead[..., 0] * behind[..., 1] - ahead[..., 1] * behind[..., 0]
    return float(np.arctan2(cross, np.einsum("...i,...i->...", ahead, behind)).min())
