"""Where the surface exists: one piece without holes, small blemishes mended."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

BLEMISH_MM2 = 1.0
"""Specks and pinholes up to this area are mended with a note [mm^2]; larger ones are the user's to decide."""
BLEMISH_SHARE = 0.01
"""Specks and pinholes up to this share of the whole area are always small, however large the print."""
MOST_PLACES = 4
"""How many places a message lists before it only counts."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Footprint:
    """The mended region and what was done to it."""

    inside: np.ndarray
    """True where the surface exists, one piece without holes, shape [ny, nx], bool."""
    notes: tuple[str, ...]
    """Sentences about what was mended."""
    problems: tuple[str, ...]
    """Sentences about what cannot be mended."""


def mend_footprint(present: np.ndarray, x_mm: np.ndarray, y_mm: np.ndarray, *, name: str) -> Footprint:
    """Keep the largest piece of a region and close its pinholes, or say why that would change the shape.

    Args:
        present: True where heights are known, shape [ny, nx], bool, some true.
        x_mm: Grid columns [mm], shape [nx].
        y_mm: Grid rows [mm], shape [ny].
        name: Named in the sentences.

    """
    cell_mm2 = float((x_mm[1] - x_mm[0]) * (y_mm[1] - y_mm[0]))
    limit = min(BLEMISH_MM2, BLEMISH_SHARE * float(present.sum()) * cell_mm2)
    notes, problems = [], []

    # Pieces hang together along edges only, so that a diagonal of single nodes is no bridge.
    pieces, areas = _regions(present, cell_mm2, diagonal=False)
    largest = int(np.argmax(areas)) + 1
    inside = pieces == largest
    others = [index for index in range(1, len(areas) + 1) if index != largest]
    large = [index for index in others if areas[index - 1] > limit]
    if large:
        problems.append(
            f"{name}: the surface seen from above falls into {len(large) + 1} separate pieces "
            f"({_places(pieces, [largest, *large], areas, x_mm, y_mm)}); one film needs one piece: "
            "join the pieces, or keep one and plan the others on their own."
        )
    elif others:
        area = sum(areas[index - 1] for index in others)
        notes.append(f"{len(others)} loose specks ({area:.2f} mm2 in all) beside the surface were removed.")

    gaps, areas = _regions(~inside, cell_mm2, diagonal=True)
    border = np.unique(np.concatenate((gaps[0], gaps[-1], gaps[:, 0], gaps[:, -1])))
    holes = [index for index in range(1, len(areas) + 1) if index not in border]
    large = [index for index in holes if areas[index - 1] > limit]
    if large:
        problems.append(
            f"{name}: the surface seen from above has {len(large)} holes larger than {limit:.2g} mm2 "
            f"({_places(gaps, large, areas, x_mm, y_mm)}); a film has none: fill the holes in the file first."
        )
    elif holes:
        area = sum(areas[index - 1] for index in holes)
        notes.append(f"{len(holes)} pinholes ({area:.2f} mm2 in all) were filled from their surroundings.")
    return Footprint(inside=inside | np.isin(gaps, holes), notes=tuple(notes), problems=tuple(problems))


def _regions(mask: np.ndarray, cell_mm2: float, *, diagonal: bool) -> tuple[np.ndarray, np.ndarray]:
    """Label connected regions and measure their areas [mm^2]."""
    labels = np.zeros(mask.shape, dtype=np.int32)
    ndimage.label(mask, np.ones((3, 3)) if diagonal else None, output=labels)
    return labels, np.bincount(labels.ravel(), minlength=int(np.max(labels)) + 1)[1:] * cell_mm2


def _places(labels: np.ndarray, indices: list[int], areas: np.ndarray, x_mm: np.ndarray, y_mm: np.ndarray) -> str:
    """Say how large some regions are and where, the largest first."""
    ranked = sorted(indices, key=lambda index: -areas[index - 1])
    centres = ndimage.center_of_mass(np.ones_like(labels), labels, ranked[:MOST_PLACES])
    texts = [
        f"{areas[index - 1]:.3g} mm2 around x = {_at(x_mm, col):.4g}, y = {_at(y_mm, row):.4g} mm"
        for index, (row, col) in zip(ranked, centres, strict=False)
    ]
    return "; ".join(texts) + ("; ..." if len(ranked) > MOST_PLACES else "")


def _at(axis_mm: np.ndarray, index: float) -> float:
    return float(np.interp(index, np.arange(len(axis_mm)), axis_mm))
