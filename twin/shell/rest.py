"""What the layers prescribe at a given activation: metrics, heights and weights of the Gauss points."""

from dataclasses import dataclass

import numpy as np

from twin.film.film import Film

GAUSS_POINTS = (-0.5 / np.sqrt(3.0), 0.5 / np.sqrt(3.0))
"""Two-point rule on a layer, in units of its hot thickness from its middle; equal weights."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RestState:
    """Coefficients of the shell's energy (see twin.shell.kernels) for each triangle; Q = 2 points a layer."""

    moments: np.ndarray
    """M0, M1, M2 on (11, 12, 22), off-diagonal doubled, shape [m, 3, 3]."""
    point_z_mm: np.ndarray
    """Heights of the Gauss points in the hot stress-free stack [mm], shape [m, Q]."""
    point_c: np.ndarray
    """w_q/2 det A_q [mm], shape [m, Q]."""
    constant: np.ndarray
    """3/2 of the summed weights [mm], shape [m]."""
    top_mm: np.ndarray
    """Height of the top face above the mid-surface in the hot stress-free stack [mm], shape [m]."""


def rest_state(film: Film, activation: float | np.ndarray) -> RestState:
    """Return the film's rest state when the fraction `activation` of the full contraction is reached.

    A layer of contraction e has lambda = 1 - e g and the spontaneous metric R diag(lambda^2, 1/lambda) R^t; being
    incompressible it is h lambda^(-1/2) thick. Layers are stacked from the flat film's mid-plane, z = 0, triangle by
    triangle: a layer may be thicker here than there, or have no thickness at all.

    Args:
        film: the film, m triangles.
        activation: g in [0, 1], a number or one value a triangle, shape [m].
    """
    stretch = 1.0 - film.contraction * activation
    if np.any(stretch <= 0.0):
        raise ValueError("contraction times activation must stay below 1")
    thickness = film.layer_thickness_mm.reshape(len(stretch), -1)
    hot = thickness / np.sqrt(stretch)
    bottom = np.cumsum(hot, axis=0) - hot
    # material coordinate of the flat mid-plane, followed into the hot stack
    below = np.cumsum(thickness, axis=0) - thickness
    part = np.clip(0.5 * thickness.sum(axis=0) - below, 0.0, thickness)
    share = np.divide(part, thickness, out=np.zeros_like(part), where=thickness > 0.0)
    middle = (share * hot).sum(axis=0)

    cos, sin = np.cos(film.director_rad), np.sin(film.director_rad)
    along, across = stretch**-2.0, stretch
    inverse = np.stack(
        (
            along * cos**2 + across * sin**2,
            2.0 * (along - across) * cos * sin,
            along * sin**2 + across * cos**2,
        ),
        axis=-1,
    )
    weight = 0.5 * thickness * film.modulus_ratio[:, None] / len(GAUSS_POINTS)
    heights = [bottom + (0.5 + s) * hot - middle for s in GAUSS_POINTS]
    moments = np.stack(
        [sum(((weight * z**power)[..., None] * inverse).sum(axis=0) for z in heights) for power in range(3)],
        axis=1,
    )
    return RestState(
        moments=moments,
        point_z_mm=np.concatenate(heights).T.copy(),
        point_c=np.concatenate([weight * stretch] * len(GAUSS_POINTS)).T.copy(),
        constant=3.0 * len(GAUSS_POINTS) * weight.sum(axis=0) * np.ones(film.triangles.shape[0]),
        top_mm=hot.sum(axis=0) - middle,
    )
