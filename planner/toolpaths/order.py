"""The order of passes: groups of equal load, and little travel inside each group."""

from collections.abc import Sequence

import numpy as np

from planner.program import Pass

ROUNDS = 20
"""Sweeps of 2-opt; it has settled long before."""


def order_passes(passes: Sequence[Pass]) -> tuple[Pass, ...]:
    """Order passes by load, lightest first, and within a load for short travel; passes may be reversed.

    Load changes wait for the pump (6 s for each gram), so each load is set once. Within a group: nearest end next,
    then 2-opt on the sequence, where reversing a stretch reverses its passes.
    """
    loads = [stroke.load_g[0] for stroke in passes]
    ordered: list[Pass] = []
    for load in sorted(set(loads)):
        group = [stroke for stroke, own in zip(passes, loads, strict=True) if own == load]
        here = np.array(ordered[-1].points_mm[-1]) if ordered else None
        ends = np.array([(stroke.points_mm[0], stroke.points_mm[-1]) for stroke in group])
        sequence, flipped = two_opt(ends, *nearest_next(ends, here))
        ordered += [reverse(group[i]) if flip else group[i] for i, flip in zip(sequence, flipped, strict=True)]
    return tuple(ordered)


def reverse(stroke: Pass) -> Pass:
    """Return the same pass scratched from its other end."""
    return Pass(
        points_mm=stroke.points_mm[::-1],
        speed_mm_s=stroke.speed_mm_s[::-1],
        load_g=stroke.load_g[::-1],
        side=stroke.side,
    )


def travel_mm(passes: Sequence[Pass]) -> float:
    """Sum the distances from the end of each pass to the beginning of the next [mm]."""
    ends = np.array([(stroke.points_mm[0], stroke.points_mm[-1]) for stroke in passes]).reshape(-1, 2, 2)
    return float(np.linalg.norm(ends[1:, 0] - ends[:-1, 1], axis=1).sum())


def nearest_next(ends: np.ndarray, here: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Go on, from each pass, to the pass with the nearest end.

    Args:
        ends: first and last point of each pass [mm], shape [n, 2, 2].
        here: where the post is [mm], shape [2]; None: above the first pass.

    Returns:
        Sequence of pass indices, shape [n], int; whether each is reversed, shape [n], bool.

    """
    left = ends.copy()
    sequence, flipped = np.empty(len(ends), dtype=int), np.zeros(len(ends), dtype=bool)
    here = ends[0, 0] if here is None else here
    for place in range(len(ends)):
        gap = np.square(left - here).sum(axis=2)
        best = int(np.argmin(gap))
        sequence[place], flipped[place] = divmod(best, 2)
        here = ends[sequence[place], 0 if flipped[place] else 1]
        left[sequence[place]] = np.inf
    return sequence, flipped


def two_opt(ends: np.ndarray, sequence: np.ndarray, flipped: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Reverse stretches of the sequence as long as that shortens the travel; arguments as of `nearest_next`.

    The first pass and its direction stay where they are.
    """
    sequence, flipped = sequence.copy(), flipped.copy()
    for _ in range(ROUNDS):
        improved = False
        for i in range(1, len(sequence)):
            rows = np.arange(len(sequence))
            entry = ends[sequence, flipped.astype(int)]
            leave = ends[sequence, 1 - flipped.astype(int)]
            after = rows[i:-1] + 1
            # Reversing i..j replaces the two moves into i and out of j; the last stretch has no move out.
            before = np.linalg.norm(entry[i] - leave[i - 1])
            gain = before - np.linalg.norm(leave[i:] - leave[i - 1], axis=1)
            gain[:-1] += np.linalg.norm(entry[after] - leave[after - 1], axis=1)
            gain[:-1] -= np.linalg.norm(entry[after] - entry[i], axis=1)
            best = int(np.argmax(gain))
            if gain[best] > 1e-9:
                stretch = slice(i, i + best + 1)
                sequence[stretch] = sequence[stretch][::-1].copy()
                flipped[stretch] = ~flipped[stretch][::-1]
                improved = True
        if not improved:
            break
    return sequence, flipped
