"""How an equilibrium moves when the alignment of the layers changes: the adjoint of the layered shell.

At an equilibrium x(q) the gradient of the energy vanishes, so with its Hessian H = d2E/dx2 and B = d2E/dx dq

    dx = -H^-1 B dq,     and for any function J(x):  dJ/dq = -B^t H^-1 dJ/dx,

one solve each with a matrix that Newton's method factorises anyway.
"""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from twin.equilibrium import Newton
from twin.inverse.forms import edge_forms, frames, pull_back
from twin.inverse.layer_response import LayerResponse
from twin.shell.topology import stencils


class Sensitivity:
    """Derivative of a film's equilibrium with respect to the alignment vectors of its triangles.

    The temperature field, the weight and the thickness of the top face are taken as they are at the equilibrium.
    """

    def __init__(self, newton: Newton) -> None:
        """Prepare for the mesh of a solver's film; `at` gives it an equilibrium."""
        self._newton = newton
        film = newton.shell.film
        self._around = stencils(film.triangles)
        self._frame = frames(film.flat_mm, film.triangles)
        # absent neighbours have no derivatives: any vertex may stand in for them
        self._slots = np.where(self._around.vertices >= 0, self._around.vertices, 0)
        places = (3 * self._slots[..., None] + np.arange(3)).ravel()
        count = len(places)
        self._gather = sp.csr_matrix((np.ones(count), (places, np.arange(count))), shape=(3 * len(film.flat_mm), count))
        self._mixed = np.empty(0)

    def at(self, vertices_mm: np.ndarray, q: np.ndarray, activation: float | np.ndarray) -> bool:
        """Linearise at an equilibrium of the film that the solver's shell has been taught; False if it is not stable.

        Args:
            vertices_mm: vertices in balance [mm], shape [n, 3].
            q: alignment vectors of that film, shape [layers, m, 2].
            activation: fraction of the full contraction, a number or shape [m].
        """
        shell = self._newton.shell
        film = shell.film
        a, b = self._forms(vertices_mm)
        layers = self._layers(q, activation)
        by_q = film.area_mm2[:, None, None] * layers.stress_by_q(a, b).reshape(len(a), 6, -1)
        _, _, values = shell.hessian(vertices_mm)
        # [m, slots and axes, layers and components]
        strain = shell.strain()
        self._mixed = np.einsum("tkfc,tfp->tkcp", strain, by_q, optimize=True).reshape(len(a), -1, by_q.shape[2])
        return self._newton.system.factorize(values)

    def forces(
        self, states_mm: Sequence[np.ndarray], q: np.ndarray, activation: float | np.ndarray
    ) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return dE/dx, [n, 3], and dE/dq, [layers, m, 2], in states of the film that the solver's shell was taught.

        The arguments are those of `at`, but the vertices need not be in balance; what `at` prepared stays.
        """
        layers, shell = self._layers(q, activation), self._newton.shell
        return [
            (shell.gradient(state)[1], shell.film.area_mm2[:, None] * layers.energy_by_q(*self._forms(state)))
            for state in states_mm
        ]

    def push(self, dq: np.ndarray) -> np.ndarray:
        """Return how the vertices move [mm] for changes of q, shape [..., layers, m, 2] -> [..., n, 3]."""
        changes = dq.reshape(-1, *dq.shape[-3:]).transpose(2, 1, 3, 0)
        force = self._mixed @ changes.reshape(len(changes), -1, changes.shape[-1])
        total = self._gather @ force.reshape(-1, force.shape[-1])
        return self.adjoint(total.T.reshape(*dq.shape[:-3], -1, 3))

    def pull(self, by_vertices: np.ndarray) -> np.ndarray:
        """Return dJ/dq, shape [..., layers, m, 2], for the gradients dJ/dx of functions, shape [..., n, 3]."""
        adjoints = self.adjoint(by_vertices).reshape(-1, by_vertices.shape[-2], 3)[:, self._slots]
        adjoints = adjoints.reshape(len(adjoints), len(self._slots), -1)
        by_q = self._mixed.swapaxes(1, 2) @ adjoints.transpose(1, 2, 0)
        by_q = by_q.reshape(len(by_q), -1, 2, len(adjoints)).transpose(3, 1, 0, 2)
        return by_q.reshape(*by_vertices.shape[:-2], *by_q.shape[1:])

    def adjoint(self, by_vertices: np.ndarray) -> np.ndarray:
        """Return -H^-1 dJ/dx, shapes [..., n, 3]."""
        system = self._newton.system
        forces = np.where(system.free, by_vertices.reshape(-1, by_vertices.shape[-2] * 3), 0.0)
        return -system.solve(forces).reshape(by_vertices.shape)

    def _layers(self, q: np.ndarray, activation: float | np.ndarray) -> LayerResponse:
        film = self._newton.shell.film
        return LayerResponse(q, film.layer_thickness_mm, activation=activation, modulus_ratio=film.modulus_ratio)

    def _forms(self, vertices_mm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the triangles' forms a and b, each [m, 3]."""
        first, second = edge_forms(vertices_mm, self._newton.shell.film.triangles, self._around)
        return pull_back(first, self._frame), pull_back(second, self._frame)
