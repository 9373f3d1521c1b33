"""How far a wide strip bends when some of its layers contract, at finite strain, and the way back."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator

from planner.calibration.strip_width import curvature_at_width

CONTRACTION_MAX = 0.6
"""The inverse is tabulated up to here; a monodomain film contracts by 0.41 to 0.45 when hot."""
NODES = 301
ITERATIONS = 50


def wide_strip(
    contraction: ArrayLike, layer_thickness_mm: Sequence[float], aligned: Sequence[int]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Bend a strip that is much wider than thick, so that it cannot curve across.

    Layers `aligned` contract by e along the strip (and swell by (1 - e)^(-1/2) across and in thickness),
    the others not at all. Minimises the layered neo-classical energy over the mid-surface's stretches p
    along and q across and the curvature k per flat length, with u(z) = p - z k at the heights z of the hot
    stress-free stack:

        W = sum over Gauss points  w ( u^2 / A1 + q^2 / A2 + A1 A2 / (u q)^2 )

    W is convex for u, q > 0, so there is one answer; at small strain the curvature is 1.125 e / H for two
    of four layers. It is the shell of the twin, reduced to a strip, so that the twin bends a calibration
    strip as measured.

    Args:
        contraction: e of the aligned layers, any shape, 0 <= e < 1.
        layer_thickness_mm: flat thickness of each layer [mm], bottom first.
        aligned: indices of the contracting layers.

    Returns:
        Bending radius of the mid-surface [mm], positive where the strip is convex seen from above (bottom
        layers contract), infinite where it stays flat; stretch along; stretch across; each of the shape of
        `contraction`.

    """
    e = np.atleast_1d(np.asarray(contraction, dtype=float))
    layers = np.where(_aligned_mask(layer_thickness_mm, aligned), e.ravel()[:, None], 0.0)
    radius, p, q = wide_stack(layers, np.asarray(layer_thickness_mm, dtype=float)[None, :])
    shape = np.shape(contraction)
    return radius.reshape(shape), p.reshape(shape), q.reshape(shape)


def wide_stack(contraction: np.ndarray, thickness_mm: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Bend wide strips of any layers along x, each with its own contraction; see `wide_strip`.

    Args:
        contraction: e of each layer along the strip, bottom first, shape [n, layers], 0 <= e < 1.
        thickness_mm: flat thickness of each layer [mm], zero allowed, shape [n, layers], or [1, layers] for all.

    Returns:
        Bending radius of the mid-surface [mm], stretch along, stretch across, as `wide_strip`, each of shape [n].

    """
    stretch = 1 - contraction
    z, weight = _hot_gauss_points(stretch, thickness_mm)
    along, across = np.repeat(stretch**2, 2, axis=1), np.repeat(1 / stretch, 2, axis=1)
    p, q, k = _minimise(z, weight, along, across)
    curvature = np.where(np.abs(k) > 1e-14, -k / p, 0.0)
    with np.errstate(divide="ignore"):
        return 1 / curvature, p, q


def radius_for_contraction(
    contraction: ArrayLike, layer_thickness_mm: Sequence[float], aligned: Sequence[int], width_mm: float | None = None
) -> np.ndarray:
    """Look up the size of the bending radius [mm] of a strip; infinite for zero contraction.

    Without a width it is a wide one, as of `wide_strip`, else it bends more, by `width_factor`.
    """
    forward, _ = _tables(tuple(layer_thickness_mm), tuple(aligned), width_mm)
    e = np.asarray(contraction, dtype=float)
    if np.any((e < 0) | (e > CONTRACTION_MAX)):
        raise ValueError(f"contraction must lie in 0..{CONTRACTION_MAX}, found {e.min():g} to {e.max():g}")
    with np.errstate(divide="ignore"):
        return 1 / np.asarray(forward(e))


def contraction_for_radius(
    radius_mm: ArrayLike, layer_thickness_mm: Sequence[float], aligned: Sequence[int], width_mm: float | None = None
) -> np.ndarray:
    """Look up the contraction that bends a strip to a radius [mm] of either sign: inverts `radius_for_contraction`.

    Raises ValueError for a radius that no contraction up to 0.6 reaches.
    """
    forward, inverse = _tables(tuple(layer_thickness_mm), tuple(aligned), width_mm)
    with np.errstate(divide="ignore"):
        curvature = 1 / np.abs(np.asarray(radius_mm, dtype=float))
    tightest = float(forward(CONTRACTION_MAX))
    if np.any(curvature > tightest):
        raise ValueError(
            f"a radius of {1 / curvature.max():.3g} mm cannot be reached, the least is {1 / tightest:.3g} mm"
        )
    return np.asarray(inverse(curvature))


@lru_cache(maxsize=16)
def _tables(
    layer_thickness_mm: tuple[float, ...], aligned: tuple[int, ...], width_mm: float | None
) -> tuple[PchipInterpolator, PchipInterpolator]:
    """Contraction -> |curvature| [1/mm] and its inverse: smooth and monotone, so a table is exact enough."""
    contraction = np.linspace(0, CONTRACTION_MAX, NODES)
    curvature = np.abs(1 / wide_strip(contraction, layer_thickness_mm, aligned)[0])
    if width_mm is not None:
        curvature = curvature_at_width(curvature, sum(layer_thickness_mm), width_mm)
    if np.any(np.diff(curvature) <= 0):
        raise ValueError(f"aligning layers {list(aligned)} of {list(layer_thickness_mm)} mm does not bend the film")
    return PchipInterpolator(contraction, curvature), PchipInterpolator(curvature, contraction)


def _aligned_mask(layer_thickness_mm: Sequence[float], aligned: Sequence[int]) -> np.ndarray:
    mask = np.zeros(len(layer_thickness_mm), dtype=bool)
    mask[list(aligned)] = True
    return mask


def _hot_gauss_points(stretch: np.ndarray, thickness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Heights [mm], shape [n, 2 layers], and weights [mm], shape [n or 1, 2 layers], of two Gauss points a layer.

    Each layer is lambda^(-1/2) times as thick as when flat; heights count from where the flat mid-plane went.
    """
    swelling = stretch**-0.5
    upper = np.cumsum(thickness, axis=1)
    lower = np.concatenate([np.zeros((len(upper), 1)), upper[:, :-1]], axis=1)
    below = np.clip(upper[:, -1:] / 2 - lower, 0, thickness)
    base = np.cumsum(swelling * thickness, axis=1) - swelling * thickness - _dot(swelling, below)[:, None]
    spots = (0.5 - 0.5 / np.sqrt(3), 0.5 + 0.5 / np.sqrt(3))
    z = np.stack([base + spot * swelling * thickness for spot in spots], axis=2)
    return z.reshape(len(stretch), -1), np.repeat(thickness / 2, 2, axis=1)


def _dot(values: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Sum values [n, points] by weights [n or 1, points] over the points, shape [n]."""
    return values @ weight[0] if len(weight) == 1 else (values * weight).sum(axis=1)


def _minimise(
    z: np.ndarray, weight: np.ndarray, along: np.ndarray, across: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Newton's method on (p, q, k) for all strips at once, shape [n] each."""
    volume = along * across
    unknown = np.tile([1.0, 1.0, 0.0], (len(z), 1))
    for _ in range(ITERATIONS):
        p, q, k = (column[:, None] for column in unknown.T)
        u = p - z * k
        du = 2 * u / along - 2 * volume / (u**3 * q**2)
        dq = 2 * q / across - 2 * volume / (u**2 * q**3)
        duu = 2 / along + 6 * volume / (u**4 * q**2)
        duq = 4 * volume / (u**3 * q**3)
        dqq = 2 / across + 6 * volume / (u**2 * q**4)
        gradient = np.stack([_dot(du, weight), _dot(dq, weight), _dot(-z * du, weight)], axis=1)
        pq, qk, pk = _dot(duq, weight), _dot(-z * duq, weight), _dot(-z * duu, weight)
        rows = [[_dot(duu, weight), pq, pk], [pq, _dot(dqq, weight), qk], [pk, qk, _dot(z * z * duu, weight)]]
        hessian = np.moveaxis(np.array(rows), 2, 0)
        step = np.linalg.solve(hessian, -gradient[:, :, None])[:, :, 0]
        # Keep every fibre's length positive: a full step from flat can turn the inner face inside out.
        shortened = step[:, :1] - z * step[:, 2:]
        with np.errstate(divide="ignore", invalid="ignore"):
            room = np.where(shortened < 0, -0.7 * u / shortened, np.inf).min(axis=1)
        unknown = unknown + np.minimum(1.0, room)[:, None] * step
        if np.abs(step).max() < 1e-13:
            break
    return unknown[:, 0], unknown[:, 1], unknown[:, 2]
