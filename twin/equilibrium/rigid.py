"""Shapes compared and turned as rigid bodies."""

import numpy as np


def moved_onto(shape_mm: np.ndarray, other_mm: np.ndarray) -> np.ndarray:
    """Return the shape turned and shifted onto another, vertex by vertex in the least squares [mm], shapes [n, 3]."""
    a, b = shape_mm - shape_mm.mean(axis=0), other_mm - other_mm.mean(axis=0)
    u, _, vt = np.linalg.svd(a.T @ b)
    turn = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
    return a @ turn + other_mm.mean(axis=0)


def rigid_distance_mm(shape_mm: np.ndarray, other_mm: np.ndarray) -> float:
    """Return the largest distance of corresponding vertices after the best rigid motion [mm], shapes [n, 3]."""
    return float(np.linalg.norm(moved_onto(shape_mm, other_mm) - other_mm, axis=1).max())
