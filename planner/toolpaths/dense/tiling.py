"""How well lines tile what is to be scratched."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from planner.toolpaths.dense.director_field import DirectorField
from planner.toolpaths.dense.lines import LEAST
from planner.toolpaths.dense.polyline import length_mm, spaced

SAMPLE_LINES = 0.125
"""Distance between the points of the film that are looked at, in line widths."""
FINE_LINES = 0.0625
"""Distance between the points that stand for a line, in line widths."""


@dataclass(frozen=True, kw_only=True)
class Tiling:
    """Shares are of the wanted area; angles are means over the lines' length."""

    coverage: float
    """Share within half a width of a line (0..1)."""
    overlap: float
    """Share covered twice or more, by different passes or by one that returns (0..1)."""
    spill: float
    """Area of film that is covered and not wanted, over the wanted area."""
    deviation_median_deg: float
    """Angle between line and director, within the wanted area [deg]."""
    deviation_95_deg: float
    passes: int
    length_mm: float

    @classmethod
    def of_nothing(cls, *, wanted: bool) -> "Tiling":
        """Describe no lines at all, where some or nothing is wanted."""
        return cls(
            coverage=0.0 if wanted else 1.0,
            overlap=0.0,
            spill=0.0,
            deviation_median_deg=0.0,
            deviation_95_deg=0.0,
            passes=0,
            length_mm=0.0,
        )


def tiling(
    lines: Sequence[np.ndarray], field: DirectorField, *, line_width_mm: float = 0.8, least: float = LEAST
) -> Tiling:
    """Measure lines against the field that they follow; arguments as of `dense_lines`."""
    film, wanted = _samples(field, least, SAMPLE_LINES * line_width_mm)
    if not lines:
        return Tiling.of_nothing(wanted=bool(wanted.any()))
    fine = [spaced(line, FINE_LINES * line_width_mm) for line in lines]
    points, tangent = np.concatenate(fine), np.concatenate([np.gradient(line, axis=0) for line in fine])
    times = _times_covered(film, fine, line_width_mm)
    reading = field.at(points)
    counted = (np.linalg.norm(reading.q, axis=1) >= least) & (reading.beyond_mm < 1e-6)
    director = np.arctan2(reading.q[counted, 1], reading.q[counted, 0]) / 2
    off = np.arctan2(tangent[counted, 1], tangent[counted, 0]) - director
    off = np.degrees(np.abs((off + np.pi / 2) % np.pi - np.pi / 2))
    area = max(1, int(wanted.sum()))
    return Tiling(
        coverage=float((times[wanted] > 0).sum() / area),
        overlap=float((times[wanted] > 1).sum() / area),
        spill=float((times[~wanted] > 0).sum() / area),
        deviation_median_deg=float(np.median(off)) if len(off) else 0.0,
        deviation_95_deg=float(np.percentile(off, 95)) if len(off) else 0.0,
        passes=len(lines),
        length_mm=sum(length_mm(line) for line in lines),
    )


def _samples(field: DirectorField, least: float, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Points of the film on a fine grid [mm], shape [n, 2], and which of them are wanted, shape [n], bool."""
    low, high = field.box_mm
    axes = [np.arange(low[k] + step / 2, high[k], step) for k in (0, 1)]
    film = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    reading = field.at(film)
    on_film = reading.beyond_mm < 1e-9
    return film[on_film], np.linalg.norm(reading.q[on_film], axis=1) >= least


def _times_covered(film: np.ndarray, lines: Sequence[np.ndarray], width: float) -> np.ndarray:
    """Count, for each film point, the separate stretches of finely spaced lines within half a width, shape [n], int."""
    owner = np.repeat(np.arange(len(lines)), [len(line) for line in lines])
    seams = np.array([line[0] for line in lines if np.array_equal(line[0], line[-1])]).reshape(-1, 2)
    # Discs of this radius around the fine points cover as much as the line's own width.
    reach = np.sqrt((width / 2) ** 2 + (FINE_LINES * width) ** 2 / 12)
    tree = KDTree(film)
    pairs = tree.sparse_distance_matrix(KDTree(np.concatenate(lines)), reach, output_type="ndarray")
    order = np.lexsort((pairs["j"], pairs["i"]))
    at, by = pairs["i"][order], pairs["j"][order]
    gap = np.diff(by) * FINE_LINES > 0.5
    begins = np.concatenate([[True], (np.diff(at) > 0) | (np.diff(owner[by]) > 0) | gap])
    stretches = np.bincount(at[begins], minlength=len(film))
    # Both ends of a ring are one stretch.
    joined = np.zeros(len(film), dtype=int)
    for near in tree.query_ball_point(seams, reach):
        joined[near] += 1
    return np.maximum(stretches - joined, stretches > 0)
