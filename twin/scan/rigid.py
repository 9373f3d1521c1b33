"""Rigid motions: how a scan is moved into the frame of its target."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True, eq=False)
class RigidTransform:
    """Rotation and translation, never a scale or a reflection: p -> rotation p + translation."""

    rotation: np.ndarray
    """Proper rotation matrix, shape [3, 3], float."""
    translation_mm: np.ndarray
    """Translation after the rotation [mm], shape [3], float."""
    residual_mm: float
    """Root mean square distance of the matched pairs after the motion [mm]."""

    def apply(self, points_mm: np.ndarray) -> np.ndarray:
        """Move points [mm], shape [n, 3]."""
        return points_mm @ self.rotation.T + self.translation_mm
