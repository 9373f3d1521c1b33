"""The layered shell as a function of its vertices: energy, gradient, Hessian."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from os import cpu_count
from typing import Any

import numpy as np
import warp as wp

from twin.film.film import Film
from twin.shell import kernels
from twin.shell.device import open_device
from twin.shell.rest import rest_state
from twin.shell.topology import gather, hessian_pattern, stencils

CHUNK = 512
"""Fewest items worth a thread of their own."""


@dataclass(frozen=True, kw_only=True)
class Loads:
    """Loads on the film, divided by the reference shear modulus."""

    weight: float = 0.0
    """rho g H / mu, dimensionless: energy per flat area is weight times z [mm]."""
    plate_per_mm: float = 0.0
    """Stiffness of the plate under the film over mu [1/mm]; 0 = no plate."""
    plate_reach_mm: float = 0.0
    """Height above the plate at which it begins to push [mm]; the larger, the smoother; 0 = an abrupt parabola."""

    @property
    def rest_height_mm(self) -> float:
        """Height at which the plate carries a flat film of this weight [mm]; 0 without a plate.

        Of `plate_energy` in twin.shell.kernels: plate d^2 / (2 reach) = weight at the depth d below the reach.
        """
        if self.plate_per_mm == 0.0:
            return 0.0
        reach, sag = self.plate_reach_mm, self.weight / self.plate_per_mm
        depth = np.sqrt(2.0 * reach * sag)
        return float(reach - depth if depth <= reach else 0.5 * reach - sag)


class Shell:
    """Energy [mm^3, divided by mu] of a film and its derivatives with respect to the vertices [mm].

    Arrays are allocated once; kernels run on `device`. A Warp launch on the CPU uses one core, so launches there are
    cut into one piece a core (the pieces write to separate places: results do not depend on their number).
    """

    def __init__(
        self, film: Film, *, loads: Loads | None = None, device: str = "cpu", threads: int | None = None
    ) -> None:
        self.film = film
        self.loads = loads or Loads()
        self.device = open_device(device)
        self._workers = 1 if self.device.is_cuda else (threads or cpu_count() or 1)
        self._pool = ThreadPoolExecutor(self._workers) if self._workers > 1 else None
        self.vertex_count = len(film.flat_mm)
        self.triangle_count = len(film.triangles)

        around = stencils(film.triangles)
        self.pattern = hessian_pattern(around.vertices, self.vertex_count)
        sources = gather(around.vertices, self.vertex_count)
        p = film.flat_mm[film.triangles]
        edges = np.stack((p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=-1)

        self._topology = kernels.Topology()
        self._topology.stencil = self._array(around.vertices, wp.int32)
        self._topology.across = self._array(around.across, wp.int32)
        self._topology.across_slot = self._array(around.across_slot, wp.int32)
        self._topology.frame = self._array(np.linalg.inv(edges), wp.mat22d)
        self._topology.area = self._array(film.area_mm2, wp.float64)
        self._vertex_area = self._array(film.vertex_area_mm2, wp.float64)
        self._gather = [self._array(a, wp.int32) for a in (sources.start, sources.triangle, sources.slot)]
        pattern = self.pattern
        self._blocks = (
            self._array(pattern.start, wp.int32),
            self._array(pattern.contribution, wp.vec3i),
            self._array(pattern.target, wp.vec3i),
            self._array(pattern.diagonal, wp.int32),
        )
        self._load_place = self._array(pattern.diagonal_place[2::3], wp.int32)

        triangles, vertices = self.triangle_count, self.vertex_count
        self._q = self._empty(vertices, wp.vec3d)
        self._geometry = kernels.Geometry()
        self._geometry.normal = self._empty(triangles, wp.vec3d)
        self._geometry.hat = self._empty((triangles, 3), wp.vec3d)
        self._response = kernels.Response()
        self._response.stress = self._empty(triangles, kernels.vec6)
        self._response.stiffness = self._empty(triangles, kernels.mat66)
        self._response.strain = self._empty((triangles, 6), kernels.mat63)
        self._triangle_energy = self._empty(triangles, wp.float64)
        self._load_energy = self._empty(vertices, wp.float64)
        self._gradient = self._empty(vertices, wp.vec3d)
        self._values = self._empty(len(pattern.indices), wp.float64)
        self.set_activation(0.0)

    def set_activation(self, activation: float | np.ndarray) -> None:
        """Prescribe the rest state at the fraction `activation` of full contraction (a number or shape [m])."""
        rest = rest_state(self.film, activation)
        self.top_mm = rest.top_mm
        self._rest = kernels.Rest()
        self._rest.moments = self._array(rest.moments, wp.mat33d)
        self._rest.point_z = self._array(rest.point_z_mm, wp.float64)
        self._rest.point_c = self._array(rest.point_c, wp.float64)
        self._rest.constant = self._array(rest.constant, wp.float64)

    def energy(self, vertices_mm: np.ndarray) -> float:
        """Return the energy over mu [mm^3]; infinite where the film folds through its own thickness."""
        self._place(vertices_mm)
        return self._energy()

    def gradient(self, vertices_mm: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the energy over mu [mm^3] and its gradient [mm^2], shape [n, 3]."""
        self._place(vertices_mm)
        energy = self._energy()
        self._differentiate(second_order=0, clamp=0)
        return energy, self._gradient.numpy().copy()

    def hessian(self, vertices_mm: np.ndarray, *, clamp: bool = False) -> tuple[float, np.ndarray, np.ndarray]:
        """Return energy over mu, gradient [n, 3] and the values of the Hessian's upper triangle in `self.pattern`.

        With `clamp` a positive semi-definite approximation: stiffness in (a, b) with its negative eigenvalues set to
        zero, membrane stress clamped to tension, no second derivatives of b.
        """
        self._place(vertices_mm)
        energy = self._energy()
        self._differentiate(second_order=1, clamp=int(clamp))
        return energy, self._gradient.numpy().copy(), self._values.numpy().copy()

    def elastic_hessian(self, vertices_mm: np.ndarray) -> np.ndarray:
        """Return the exact Hessian of the elastic energy alone, as if weight and plate were gone."""
        self._place(vertices_mm)
        self._differentiate(second_order=1, clamp=0, loaded=False)
        return self._values.numpy().copy()

    def driving_force(self, vertices_mm: np.ndarray) -> float:
        """Return the norm of all element and load forces over mu [mm^2], before they cancel.

        The scale that residuals are measured by; a film without any force gives a floor far below them.
        """
        self._place(vertices_mm)
        self._differentiate(second_order=0, clamp=0)
        strain, stress = self._response.strain.numpy(), self._response.stress.numpy()
        forces = np.einsum("tkij,ti->tkj", strain, stress)
        loads = abs(self.loads.weight) * float(np.linalg.norm(self.film.vertex_area_mm2))
        area = self.film.area_mm2
        floor = 1e-5 * self.film.thickness_mm * float(np.sqrt(area.sum()))
        return max(float(np.linalg.norm(forces)) + loads, floor)

    def _place(self, vertices_mm: np.ndarray) -> None:
        self._q.assign(np.ascontiguousarray(vertices_mm, dtype=np.float64))
        self._launch(kernels.triangle_geometry, self.triangle_count, [self._topology, self._q], [self._geometry])

    def _energy(self) -> float:
        inputs = [self._topology, self._rest, self._q, self._geometry]
        self._launch(kernels.triangle_energy, self.triangle_count, inputs, [self._triangle_energy])
        total = float(self._triangle_energy.numpy().sum())
        if self._loaded:
            self._add_loads(second_order=0)
            total += float(self._load_energy.numpy().sum())
        return total if total < 1e200 else np.inf

    @property
    def _loaded(self) -> bool:
        return self.loads.weight != 0.0 or self.loads.plate_per_mm != 0.0

    def _add_loads(self, *, second_order: int) -> None:
        loads = self.loads
        inputs = [self._vertex_area, loads.weight, loads.plate_per_mm, loads.plate_reach_mm, self._q, self._load_place]
        outputs = [self._load_energy, self._gradient, self._values]
        self._launch(kernels.add_loads, self.vertex_count, [*inputs, second_order], outputs)

    def _differentiate(self, *, second_order: int, clamp: int, loaded: bool = True) -> None:
        inputs = [self._topology, self._rest, self._q, self._geometry, second_order, clamp]
        self._launch(kernels.triangle_response, self.triangle_count, inputs, [self._response])
        self._launch(kernels.vertex_gradient, self.vertex_count, [self._response, *self._gather], [self._gradient])
        if second_order:
            inputs = [self._topology, self._geometry, self._response, self._q, *self._blocks, clamp]
            self._launch(kernels.hessian_blocks, len(self.pattern.diagonal), inputs, [self._values])
        if loaded and self._loaded:
            self._add_loads(second_order=second_order)

    def _launch(self, kernel: Any, count: int, inputs: list, outputs: list) -> None:
        if self._pool is None or count < 2 * CHUNK:
            wp.launch(kernel, dim=count, inputs=[*inputs, 0], outputs=outputs, device=self.device)
            return
        bounds = np.linspace(0, count, self._workers + 1).astype(int)
        jobs = [
            self._pool.submit(
                wp.launch,
                kernel,
                dim=int(last - first),
                inputs=[*inputs, int(first)],
                outputs=outputs,
                device=self.device,
            )
            for first, last in pairwise(bounds)
        ]
        for job in jobs:
            job.result()

    def _array(self, values: np.ndarray, dtype: Any) -> wp.array:
        return wp.array(np.ascontiguousarray(values), dtype=dtype, device=self.device)

    def _empty(self, shape: int | tuple[int, ...], dtype: type) -> wp.array:
        return wp.zeros(shape, dtype=dtype, device=self.device)
