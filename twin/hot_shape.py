"""What a prediction gives: the film's shapes along the ramp, and how far they can be trusted."""

from dataclasses import dataclass

import numpy as np

from twin.film import Film


@dataclass(frozen=True, kw_only=True)
class Stop:
    """The film at a temperature that was asked for."""

    temperature_c: float
    """Temperature of the plate [C]."""
    index: int
    """Its place among the accepted temperatures."""
    stable: bool
    """Whether the Hessian is positive definite there."""
    relative_residual: float
    """As of the hot shape."""


@dataclass(frozen=True, kw_only=True)
class Snap:
    """A jump of the film to another shape."""

    temperature_c: float
    """Accepted temperature before which it happened [C]."""
    distance_mm: float
    """How far the film is from its shape before when it goes back there [mm]."""
    cooling: bool
    """Whether the film was being cooled."""


@dataclass(frozen=True, kw_only=True, eq=False)
class HotShape:
    """The film at each accepted temperature of the ramp, flat and cold first, and how well it is in balance."""

    film: Film
    temperature_c: np.ndarray
    """Accepted temperatures [C], shape [k]; ascending unless the film was cooled on the way."""
    vertices_mm: np.ndarray
    """Mid-surface at each of them [mm], z = 0 on the plate, shape [k, n, 3].

    Where the ramp was followed on a coarser mesh, all but the stops are carried over from there."""
    stops: tuple[Stop, ...]
    """The temperatures that were asked for, in their order."""
    hottest: int
    """Place of the hot shape among the accepted temperatures: the first at the highest of the stops."""
    top_mm: np.ndarray
    """Top face of the hot shape, what a scanner sees [mm], shape [n, 3]."""
    energy_mj: float
    """Elastic energy plus that of weight and contact of the hot shape [mJ]."""
    relative_residual: float
    """Norm of the residual force over the norm of all element and load forces of the still-flat film."""
    stable: bool
    """Whether the Hessian is positive definite there."""
    lowest_stiffness_n_mm3: float
    """Its lowest eigenvalue per area: how stiffly the film opposes its softest disturbance [N/mm^3]."""
    tapped_away_at_c: tuple[float, ...]
    """Temperatures at which the film was held down only by its weight and a small tap let it jump elsewhere."""
    snaps: tuple[Snap, ...]
    """Where the film jumped by itself."""
    newton_iterations: int
    device: str
    wall_s: float

    @property
    def hot_mm(self) -> np.ndarray:
        """Mid-surface of the hot shape [mm], shape [n, 3]."""
        return self.vertices_mm[self.hottest]

    @property
    def snapped_at_c(self) -> tuple[float, ...]:
        """Temperatures at which the film jumped by itself [C]."""
        return tuple(snap.temperature_c for snap in self.snaps)
