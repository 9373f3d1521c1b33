"""The flat film: its triangles and what each layer was taught."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True, eq=False)
class Film:
    """Mid-surface mesh of the flat film with a director and a contraction for each layer of each triangle."""

    flat_mm: np.ndarray
    """Vertices of the flat film [mm], shape [n, 2], float."""
    triangles: np.ndarray
    """Vertex indices, counter-clockwise, shape [m, 3], int."""
    layer_thickness_mm: np.ndarray
    """Thickness of each layer when flat [mm], bottom first, shape [layers], or [layers, m] where it varies, float."""
    director_rad: np.ndarray
    """Director angle from +x, modulo pi [rad], shape [layers, m], float."""
    contraction: np.ndarray
    """Contraction e along the director at full activation, 0 = polydomain, shape [layers, m], float."""
    modulus_ratio: np.ndarray
    """Shear modulus of each layer over the reference modulus, shape [layers], float."""

    @property
    def thickness_mm(self) -> float:
        """Thickness of the flat film [mm], its mean over the area where it varies."""
        total = self.layer_thickness_mm.sum(axis=0)
        return float(total) if total.ndim == 0 else float(total @ self.area_mm2 / self.area_mm2.sum())

    @property
    def vertex_thickness_mm(self) -> float | np.ndarray:
        """Thickness of the flat film [mm]; where it varies the mean around each vertex, shape [n]."""
        total = self.layer_thickness_mm.sum(axis=0)
        if total.ndim == 0:
            return float(total)
        volume = np.repeat(self.area_mm2 * total / 3.0, 3)
        return np.bincount(self.triangles.ravel(), volume, len(self.flat_mm)) / self.vertex_area_mm2

    @property
    def alignment(self) -> np.ndarray:
        """Alignment vectors q = e (cos 2 theta, sin 2 theta) of each layer, shape [layers, m, 2]."""
        double = 2.0 * self.director_rad
        return np.stack((self.contraction * np.cos(double), self.contraction * np.sin(double)), axis=-1)

    @property
    def area_mm2(self) -> np.ndarray:
        """Flat area of each triangle [mm^2], shape [m]."""
        p = self.flat_mm[self.triangles]
        u, v = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
        return 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])

    @property
    def vertex_area_mm2(self) -> np.ndarray:
        """A third of the flat area of the triangles around each vertex [mm^2], shape [n]."""
        share = np.repeat(self.area_mm2 / 3.0, 3)
        return np.bincount(self.triangles.ravel(), weights=share, minlength=len(self.flat_mm))
