"""Lengths along a polyline."""

import numpy as np


def length_mm(line: np.ndarray) -> float:
    """Measure a polyline [mm], shape [k, 2]."""
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def spaced(line: np.ndarray, step_mm: float) -> np.ndarray:
    """Place points on a polyline [mm], shape [k, 2], at equal distances of about `step_mm`, ends included."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    places = np.linspace(0, along[-1], max(2, round(along[-1] / step_mm) + 1))
    return np.stack([np.interp(places, along, line[:, axis]) for axis in (0, 1)], axis=1)
