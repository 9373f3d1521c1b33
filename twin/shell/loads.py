"""Weight and plate."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True)
class Loads:
    """Loads on the film, divided by the reference shear modulus."""

    weight: float | np.ndarray = 0.0
    """rho g H / mu, dimensionless: energy per flat area is weight times z [mm]; a number or one a vertex, shape [n]."""
    plate_per_mm: float = 0.0
    """Stiffness of the plate under the film over mu [1/mm]; 0 = no plate."""
    plate_reach_mm: float = 0.0
    """Height above the plate at which it begins to push [mm]; the larger, the smoother; 0 = an abrupt parabola."""

    @property
    def heavy(self) -> bool:
        """Whether the film weighs anything."""
        return bool(np.any(self.weight))

    @property
    def rest_height_mm(self) -> float:
        """Height at which the plate carries a flat film of this weight [mm]; 0 without a plate.

        Of `plate_energy` in twin.shell.kernels: plate d^2 / (2 reach) = weight at the depth d below the reach.
        """
        if self.plate_per_mm == 0.0:
            return 0.0
        reach, sag = self.plate_reach_mm, float(np.mean(self.weight)) / self.plate_per_mm
        depth = np.sqrt(2.0 * reach * sag)
        return float(reach - depth if depth <= reach else 0.5 * reach - sag)
