"""Films of one mesh side by side on the device, each a world of its own, evaluated in one launch."""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from os import cpu_count
from typing import Any, cast

import numpy as np
import warp as wp

from twin.film.film import Film
from twin.shell import kernels
from twin.shell.loads import Loads
from twin.shell.rest import RestState
from twin.shell.topology import gather, hessian_pattern, stencils

CHUNK = 512
"""Fewest items worth a thread of their own."""


@dataclass(frozen=True, kw_only=True)
class Want:
    """What is asked beside the energy."""

    order: int = 0
    """1 for the gradient, 2 for the Hessian too."""
    clamp: bool = False
    """Whether the Hessian is the positive semi-definite approximation."""
    loaded: bool = True
    """Whether weight and plate count."""


@dataclass(frozen=True, kw_only=True, eq=False)
class State:
    """A film as it is to be evaluated."""

    vertices_mm: np.ndarray
    """Vertices [mm], shape [n, 3]."""
    rest: RestState
    """What its layers prescribe; uploaded where it is not the object that the world has already."""
    weight: np.ndarray
    """rho g H / mu of each vertex, see `Loads`, shape [n]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Evaluation:
    """The energy and what was asked for beside it; what was not is empty."""

    energy: float
    """Energy over mu [mm^3]; infinite where the film folds through its own thickness."""
    gradient: np.ndarray
    """Gradient [mm^2], shape [n, 3]."""
    hessian: np.ndarray
    """Values of the Hessian's upper triangle [mm], in the order of `Worlds.pattern`."""


class Worlds:
    """Device arrays of films of one mesh that differ in what their layers prescribe, in weight and in shape.

    The worlds lie in the arrays one after another, as unconnected pieces of one mesh. A Warp launch on the CPU uses
    one core, so launches there are cut into one piece a core. Every item writes to its own place: results depend
    neither on the number of pieces nor on the other worlds.
    """

    def __init__(
        self, film: Film, *, loads: Loads, device: wp.Device, count: int = 1, threads: int | None = None
    ) -> None:
        """Allocate the arrays.

        Args:
            film: a film with the mesh and the number of layers of all.
            loads: the plate of all; the weight is each world's own.
            device: where the kernels run.
            count: number of worlds.
            threads: pieces that launches on the CPU are cut into; None for one a core.
        """
        self.device, self._loads, self._count = device, loads, count
        self._workers = 1 if device.is_cuda else (threads or cpu_count() or 1)
        self._pool = ThreadPoolExecutor(self._workers) if self._workers > 1 else None
        around = stencils(film.triangles)
        vertices, triangles = len(film.flat_mm), len(film.triangles)
        self.pattern = pattern = hessian_pattern(around.vertices, vertices)
        sources = gather(around.vertices, vertices)
        blocks, entries = len(pattern.diagonal), len(pattern.indices)
        p = film.flat_mm[film.triangles]
        edges = np.stack((p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=-1)

        self._topology = kernels.Topology()
        self._topology.stencil = self._each_world(around.vertices, wp.int32, vertices)
        self._topology.across = self._each_world(around.across, wp.int32, triangles)
        self._topology.across_slot = self._each_world(around.across_slot, wp.int32)
        self._topology.frame = self._each_world(np.linalg.inv(edges), wp.mat22d)
        self._topology.area = self._each_world(film.area_mm2, wp.float64)
        self._vertex_area = self._each_world(film.vertex_area_mm2, wp.float64)
        self._gather = (
            self._each_world(sources.start[:-1], wp.int32, len(sources.slot), end=True),
            self._each_world(sources.triangle, wp.int32, triangles),
            self._each_world(sources.slot, wp.int32),
        )
        self._blocks = (
            self._each_world(pattern.start[:-1], wp.int32, len(pattern.contribution), end=True),
            self._each_world(pattern.contribution, wp.vec3i, np.array([triangles, 0, 0])),
            self._each_world(pattern.target, wp.vec3i, entries),
            self._each_world(pattern.diagonal, wp.int32),
        )
        self._load_place = self._each_world(pattern.diagonal_place[2::3], wp.int32, entries)

        points = 2 * len(film.contraction)
        self._rest = kernels.Rest()
        self._rest.moments = self._empty(triangles, wp.mat33d)
        self._rest.point_z = self._empty((triangles, points), wp.float64)
        self._rest.point_c = self._empty((triangles, points), wp.float64)
        self._rest.constant = self._empty(triangles, wp.float64)
        self._weight = self._empty(vertices, wp.float64)
        self._q = self._empty(vertices, wp.vec3d)
        self._geometry = kernels.Geometry()
        self._geometry.normal = self._empty(triangles, wp.vec3d)
        self._geometry.hat = self._empty((triangles, 3), wp.vec3d)
        self._response = kernels.Response()
        self._response.stress = self._empty(triangles, kernels.vec6)
        self._response.stiffness = self._empty(triangles, kernels.mat66)
        self._response.strain = self._empty((triangles, 6), kernels.mat63)
        self._bending = kernels.Bending()
        self._bending.edge = self._empty((triangles, 3), kernels.vec3)
        self._bending.slot = self._empty((triangles, 12), kernels.vec5)
        self._triangle_energy = self._empty(triangles, wp.float64)
        self._load_energy = self._empty(vertices, wp.float64)
        self._gradient = self._empty(vertices, wp.vec3d)
        self._values = self._empty(entries, wp.float64)
        self._triangles, self._vertices, self._block_count = triangles, vertices, blocks
        self._prescribed: list[tuple[RestState, np.ndarray] | None] = [None] * count

    def evaluate(self, want: Want, states: Mapping[int, State]) -> dict[int, Evaluation]:
        """Return what is wanted of some worlds, each in its state, by their numbers."""
        for number, state in states.items():
            self._upload(number, state)
        worlds = wp.array(np.array(sorted(states), dtype=np.int32), dtype=wp.int32, device=self.device)
        geometry, response = self._geometry, self._response
        triangles, vertices = (worlds, self._triangles), (worlds, self._vertices)
        inputs = [self._topology, self._q]
        self._launch(kernels.triangle_geometry, triangles, inputs, [geometry])
        inputs = [self._topology, self._rest, self._q, geometry]
        self._launch(kernels.triangle_energy, triangles, inputs, [self._triangle_energy])
        if want.order > 0:
            order = [int(want.order > 1), int(want.clamp)]
            self._launch(kernels.triangle_response, triangles, [*inputs, *order], [response])
            self._launch(kernels.vertex_gradient, vertices, [response, *self._gather], [self._gradient])
        if want.order > 1:
            if not want.clamp:
                inputs = [self._topology, geometry, response, self._q]
                self._launch(kernels.edge_bending, triangles, inputs, [self._bending])
            inputs = [self._topology, geometry, response, self._bending, *self._blocks, int(want.clamp)]
            self._launch(kernels.hessian_blocks, (worlds, self._block_count), inputs, [self._values])
        if want.loaded:
            plate = [self._loads.plate_per_mm, self._loads.plate_reach_mm]
            inputs = [self._vertex_area, self._weight, *plate, self._q, self._load_place, int(want.order > 1)]
            self._launch(kernels.add_loads, vertices, inputs, [self._load_energy, self._gradient, self._values])
        return {number: self._download(number, want) for number in states}

    def response(self, number: int) -> tuple[np.ndarray, np.ndarray]:
        """Return a world's stress, shape [m, 6], and d(a, b)/dq, shape [m, 6, 6, 3], where it was last differentiated.

        See `Response` in twin.shell.kernels. Not a copy: the next evaluation may overwrite them.
        """
        return self._part(self._response.stress, number).numpy(), self._part(self._response.strain, number).numpy()

    def _upload(self, number: int, state: State) -> None:
        self._copy_in(self._q, number, state.vertices_mm)
        prescribed = self._prescribed[number]
        if prescribed is None or prescribed[0] is not state.rest:
            self._copy_in(self._rest.moments, number, state.rest.moments)
            self._copy_in(self._rest.point_z, number, state.rest.point_z_mm)
            self._copy_in(self._rest.point_c, number, state.rest.point_c)
            self._copy_in(self._rest.constant, number, state.rest.constant)
        if prescribed is None or prescribed[1] is not state.weight:
            self._copy_in(self._weight, number, state.weight)
        self._prescribed[number] = (state.rest, state.weight)

    def _download(self, number: int, want: Want) -> Evaluation:
        energy = float(self._copy_out(self._triangle_energy, number).sum())
        if want.loaded:
            energy += float(self._copy_out(self._load_energy, number).sum())
        gradient = hessian = np.empty(0)
        if want.order > 0:
            gradient = self._copy_out(self._gradient, number)
        if want.order > 1:
            hessian = self._copy_out(self._values, number)
        return Evaluation(energy=energy if energy < 1e200 else np.inf, gradient=gradient, hessian=hessian)

    def _launch(self, kernel: Any, over: tuple[wp.array, int], inputs: list, outputs: list) -> None:
        """Launch a kernel over some worlds with so many items each."""
        count = over[1] * len(over[0])
        if self._pool is None or count < 2 * CHUNK:
            wp.launch(kernel, dim=count, inputs=[*inputs, *over, 0], outputs=outputs, device=self.device)
            return
        bounds = np.linspace(0, count, self._workers + 1).astype(int)
        jobs = [
            self._pool.submit(
                wp.launch,
                kernel,
                dim=int(last - first),
                inputs=[*inputs, *over, int(first)],
                outputs=outputs,
                device=self.device,
            )
            for first, last in pairwise(bounds)
        ]
        for job in jobs:
            job.result()

    def _part(self, array: wp.array, number: int) -> wp.array:
        """View of what belongs to one world."""
        each = array.shape[0] // self._count
        return cast(wp.array, array[number * each : (number + 1) * each])

    def _copy_in(self, array: wp.array, number: int, values: np.ndarray) -> None:
        self._part(array, number).assign(np.ascontiguousarray(values, dtype=np.float64))

    def _copy_out(self, array: wp.array, number: int) -> np.ndarray:
        return self._part(array, number).numpy().copy()

    def _each_world(self, values: np.ndarray, dtype: Any, step: int | np.ndarray = 0, *, end: bool = False) -> wp.array:
        """Repeat constant values for each world, raised by `step` from one to the next; -1 stays -1.

        With `end` the values are offsets, and where the last ones end is appended.
        """
        repeated = [np.where(values < 0, values, values + number * step) for number in range(self._count)]
        flat = np.concatenate(repeated)
        return wp.array(np.append(flat, self._count * step) if end else flat, dtype=dtype, device=self.device)

    def _empty(self, shape: int | tuple[int, ...], dtype: Any) -> wp.array:
        first, *others = (shape,) if isinstance(shape, int) else shape
        return wp.zeros((self._count * first, *others), dtype=dtype, device=self.device)
