"""How well lines tile what is to be scratched."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from planner.toolpaths.dense.director_field import DirectorField
from planner.toolpaths.dense.lines import LEAST
from planner.toolpaths.dense.polyline import length_mm, spaced

SAMPLE_MM = 0.1
"""Distance between the points of the film that are looked at."""
FINE_MM = 0.05
"""Distance between the points that stand for a line."""


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
    film, wanted = _samples(field, least)
    if not lines:
        return Tiling.of_nothing(wanted=bool(wanted.any()))
    fine = [spaced(line, FINE_MM) for line in lines]
    points, tangent = np.concatenate(fine), np.concatenate([np.gradient(line, axis=0) for line in fine])
    owner = np.repeat(np.arange(len(fine)), [len(line) for line in fine])
    times = _times_covered(film, points, owner, line_width_mm)
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


def _samples(field: DirectorField, least: float) -> tuple[np.ndarray, np.ndarray]:
    """Points of the film on a fine grid [mm], shape [n, 2], and which of them are wanted, shape [n], bool."""
    low, high = field.box_mm
    axes = [np.arange(low[k] + SAMPLE_MM / 2, high[k], SAMPLE_MM) for k in (0, 1)]
    film = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    reading = field.at(film)
    on_film = reading.beyond_mm < 1e-9
    return film[on_film], np.linalg.norm(reading.q[on_film], axis=1) >= least


def _times_covered(film: np.ndarray, points: np.ndarray, owner: np.ndarray, width: float) -> np.ndarray:
    """Count, for each film point, the separate stretches of lines within half a width, shape [n], int."""
    # Discs of this radius around the fine points cover as much as the line's own width.
    reach = np.sqrt((width / 2) ** 2 + FINE_MM**2 / 12)
    pairs = KDTree(film).sparse_distance_matrix(KDTree(points), reach, output_type="ndarray")
    order = np.lexsort((pairs["j"], pairs["i"]))
    at, by = pairs["i"][order], pairs["j"][order]
    gap = np.diff(by) * FINE_MM > width / 2
    begins = np.concatenate([[True], (np.diff(at) > 0) | (np.diff(owner[by]) > 0) | gap])
    return np.bincount(at[begins], minlength=len(film))
