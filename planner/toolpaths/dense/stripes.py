"""Stripes of one width along a director field: a Swift-Hohenberg pattern."""

from dataclasses import dataclass
from typing import cast

import numpy as np
from scipy.fft import irfft2, rfft2

from planner.toolpaths.dense.grid import FieldGrid

GROWTH = 0.2
"""r below: how firmly stripes form; softer stripes end and bend more freely."""
OUTSIDE_GROWTH = -0.2
"""r where nothing is wanted: stripes die out there and may end anywhere."""
ALIGNMENT = (2.0, 1.0)
"""a below, from the first step to the middle one, and from there on: stiff stripes first find long ways, then give."""
TIME_STEP = 3.0
STEPS = 400
OVERRUN_LINES = 1.5
"""Stripes go on this far outside the wanted region, in line widths: what they do at their border is cut away."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Stripes:
    """A pattern on a grid; its ridges are the lines."""

    height: np.ndarray
    """Shape [nx, ny]."""
    slope: np.ndarray
    """Gradient of the height times the line width over 2 pi, shape [2, nx, ny]."""


def stripes(grid: FieldGrid, line_width_mm: float, seed: int) -> Stripes:
    """Grow stripes one line width apart along the director, from noise, to rest.

    Descends the energy (lengths in units of the line width over 2 pi)

        E(u) = 1/2 |(1 + lap) u|^2 + a/2 |n . grad u|^2 - r/2 u^2 + 1/4 u^4

    with the director n: the first term wants one spacing, the second stripes along n. Both give way where n
    diverges, and stripes end at dislocations, which the descent moves to where they cost least. u is a real height
    and n enters squared: a director modulo pi needs no orientation, and its half-integer singularities no care.

    Source: Swift, Hohenberg, Phys. Rev. A 15 (1977) 319, with an alignment term; linear terms are taken implicitly, in
    Fourier space.
    """
    size = grid.theta_rad.shape
    unit = line_width_mm / (2 * np.pi)
    kx = (2 * np.pi * unit * np.fft.fftfreq(size[0], grid.cell_mm))[:, None].astype(np.float32)
    ky = (2 * np.pi * unit * np.fft.rfftfreq(size[1], grid.cell_mm))[None, :].astype(np.float32)
    ikx, iky = (1j * kx).astype(np.complex64), (1j * ky).astype(np.complex64)
    near = grid.outside_mm < OVERRUN_LINES * line_width_mm
    growth = np.where(near, GROWTH, OUTSIDE_GROWTH).astype(np.float32)
    nx, ny = np.cos(grid.theta_rad).astype(np.float32), np.sin(grid.theta_rad).astype(np.float32)
    noise = np.random.default_rng(seed).normal(scale=0.01, size=size).astype(np.float32)
    wave = _forward(noise)
    square = kx**2 + ky**2
    spacing = (1 - square) ** 2
    for step in range(STEPS):
        align = np.float32(np.interp(step, (0, STEPS / 2), ALIGNMENT))
        # Half the alignment taken from all directions alike, implicitly, keeps the explicit step stable.
        steady = align / 2 * square
        height = _backward(wave, size)
        along = align * (nx * _backward(ikx * wave, size) + ny * _backward(iky * wave, size))
        push = _forward((growth - height**2) * height) + ikx * _forward(nx * along) + iky * _forward(ny * along)
        wave = (wave + TIME_STEP * (steady * wave + push)) / (1 + TIME_STEP * (spacing + steady))
    slope = np.stack([_backward(ikx * wave, size), _backward(iky * wave, size)])
    return Stripes(height=_backward(wave, size), slope=slope)


def _forward(values: np.ndarray) -> np.ndarray:
    return cast(np.ndarray, rfft2(values))


def _backward(wave: np.ndarray, size: tuple[int, ...]) -> np.ndarray:
    return cast(np.ndarray, irfft2(wave, s=size))
