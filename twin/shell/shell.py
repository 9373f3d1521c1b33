"""The layered shell as a function of its vertices: energy, gradient, Hessian."""

import numpy as np
import warp as wp

from twin.film.film import Film
from twin.shell.home import world_for
from twin.shell.loads import Loads
from twin.shell.rest import RestState, rest_state
from twin.shell.topology import Pattern
from twin.shell.worlds import Evaluation, State, Want

ENERGY, GRADIENT = Want(), Want(order=1)
HESSIAN, CLAMPED_HESSIAN, ELASTIC_HESSIAN = Want(order=2), Want(order=2, clamp=True), Want(order=2, loaded=False)


class Shell:
    """Energy [mm^3, divided by mu] of a film and its derivatives with respect to the vertices [mm]."""

    def __init__(
        self, film: Film, *, loads: Loads | None = None, device: str = "cpu", threads: int | None = None
    ) -> None:
        self.film = film
        self.loads = loads or Loads()
        self.vertex_count = len(film.flat_mm)
        self.triangle_count = len(film.triangles)
        self._world = world_for(film, loads=self.loads, device=device, threads=threads)
        self._weight = np.broadcast_to(self.loads.weight, self.vertex_count)
        self.set_activation(0.0)

    @property
    def device(self) -> wp.Device:
        """Where the kernels run."""
        return self._world.device

    @property
    def pattern(self) -> Pattern:
        """Layout of the Hessian's upper triangle."""
        return self._world.pattern

    def set_activation(self, activation: float | np.ndarray) -> None:
        """Prescribe the rest state at the fraction `activation` of full contraction (a number or shape [m])."""
        self.prescribe(rest_state(self.film, activation))

    def prescribe(self, rest: RestState) -> None:
        """Prescribe a rest state of the film's mesh and number of layers, whether its layers give that or not."""
        self._rest, self.top_mm = rest, rest.top_mm

    def teach(self, film: Film, activation: float | np.ndarray) -> None:
        """Replace the film by one with the same mesh and other layers, and prescribe its rest state.

        Raises:
            ValueError: if the mesh is another one.
        """
        same = film.triangles is self.film.triangles or np.array_equal(film.triangles, self.film.triangles)
        if not (same and np.array_equal(film.flat_mm, self.film.flat_mm)):
            raise ValueError("a shell can be taught a film of its own mesh only")
        self.film = film
        self.set_activation(activation)

    def energy(self, vertices_mm: np.ndarray) -> float:
        """Return the energy over mu [mm^3]; infinite where the film folds through its own thickness."""
        return self._evaluate(ENERGY, vertices_mm).energy

    def gradient(self, vertices_mm: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the energy over mu [mm^3] and its gradient [mm^2], shape [n, 3]."""
        found = self._evaluate(GRADIENT, vertices_mm)
        return found.energy, found.gradient

    def hessian(self, vertices_mm: np.ndarray, *, clamp: bool = False) -> tuple[float, np.ndarray, np.ndarray]:
        """Return energy over mu, gradient [n, 3] and the values of the Hessian's upper triangle in `self.pattern`.

        With `clamp` a positive semi-definite approximation: stiffness in (a, b) with its negative eigenvalues set to
        zero, membrane stress clamped to tension, no second derivatives of b.
        """
        found = self._evaluate(CLAMPED_HESSIAN if clamp else HESSIAN, vertices_mm)
        return found.energy, found.gradient, found.hessian

    def elastic_hessian(self, vertices_mm: np.ndarray) -> np.ndarray:
        """Return the exact Hessian of the elastic energy alone, as if weight and plate were gone."""
        return self._evaluate(ELASTIC_HESSIAN, vertices_mm).hessian

    def strain(self) -> np.ndarray:
        """Return d(a, b)/dq for the stencil of each triangle at the vertices differentiated last, [m, 6, 6, 3]."""
        return self._world.response()[1]

    def driving_force(self, vertices_mm: np.ndarray) -> float:
        """Return the norm of all element and load forces over mu [mm^2], before they cancel.

        The scale that residuals are measured by; a film without any force gives a floor far below them.
        """
        self._evaluate(GRADIENT, vertices_mm)
        stress, strain = self._world.response()
        forces = np.einsum("tkij,ti->tkj", strain, stress)
        loads = float(np.linalg.norm(self.loads.weight * self.film.vertex_area_mm2))
        area = self.film.area_mm2
        floor = 1e-5 * self.film.thickness_mm * float(np.sqrt(area.sum()))
        return max(float(np.linalg.norm(forces)) + loads, floor)

    def _evaluate(self, want: Want, vertices_mm: np.ndarray) -> Evaluation:
        return self._world.evaluate(want, State(vertices_mm=vertices_mm, rest=self._rest, weight=self._weight))
