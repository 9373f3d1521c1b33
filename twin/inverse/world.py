"""One film of a design: its equilibrium, and how that answers to the design."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from twin.film import Film, film_from_alignment
from twin.inverse.mismatch import Measured, Mismatch
from twin.inverse.sensitivity import Sensitivity
from twin.predict import PredictOptions, heat_film, open_newton, ramp_end, top_face
from twin.shell import Shell

TOLERANCE = 1e-7
"""Relative residual of a design's equilibria: far below what moves a score, cheap by Newton's last step."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Shape:
    """The equilibrium of one film and how far it is from the target."""

    vertices_mm: np.ndarray
    """Mid-surface [mm], shape [n, 3]."""
    top_mm: np.ndarray
    """Top face [mm], shape [n, 3]."""
    measured: Measured


class World:
    """A film on its mesh under its loads, taught one design after the other."""

    def __init__(self, film: Film, mismatch: Mismatch, heated: PredictOptions) -> None:
        """Prepare.

        Args:
            film: a film on the mesh; its alignment is replaced.
            mismatch: measures the shapes.
            heated: loads and temperature at which the film should have its shape.
        """
        self.newton = open_newton(film, heated)
        self._mismatch, self._heated = mismatch, heated
        self.activation = ramp_end(heated)
        """Fraction of the full contraction that everything but ramps is worked out at; may be replaced."""
        self._sensitivity = Sensitivity(self.newton)
        area = film.vertex_area_mm2
        self.vertex_share = (area / area.sum())[:, None]
        """Share of the film's area that belongs to each vertex, shape [n, 1]."""
        self._flat = np.column_stack((film.flat_mm, np.zeros(len(film.flat_mm))))

    def film(self, q: np.ndarray) -> Film:
        """Return the film whose triangles have the alignment q, shape [layers, m, 2]."""
        film = self.newton.shell.film
        return film_from_alignment(
            film.flat_mm,
            film.triangles,
            q,
            layer_thickness_mm=film.layer_thickness_mm,
            modulus_ratio=film.modulus_ratio,
        )

    def balance(self, q: np.ndarray, start_mm: np.ndarray) -> np.ndarray:
        """Return the equilibrium near a start [mm], shape [n, 3].

        Raises:
            SolverError: if there is none.
        """
        scale = self._teach(q).driving_force(self._flat)
        return self.newton.solve(start_mm, force_scale=scale, tolerance=TOLERANCE).vertices_mm

    def settle(self, q: np.ndarray, start_mm: np.ndarray, near: Shape | None = None) -> Shape:
        """Find the equilibrium near a start [mm], shape [n, 3], and measure it.

        Raises:
            SolverError: if there is none.
        """
        vertices = self.balance(q, start_mm)
        shell = self.newton.shell
        top = top_face(shell.film, vertices, shell.top_mm)
        measured = self._mismatch.measure(top, None if near is None else near.measured.transform)
        return Shape(vertices_mm=vertices, top_mm=top, measured=measured)

    def states(self, q: np.ndarray) -> list[tuple[float, np.ndarray]]:
        """Heat the film of q from flat; returns activations and vertices [mm], shape [n, 3], about in balance.

        Raises:
            SolverError: if no equilibrium is found on the way.
        """
        found = heat_film(self.film(q), self._heated)
        activation = self._heated.material.activation(found.temperature_c)
        return list(zip(activation.tolist(), found.vertices_mm, strict=True))

    def ramp(self, q: np.ndarray) -> np.ndarray:
        """Heat the film of q from flat as a prediction does; returns where it ends [mm], shape [n, 3].

        Raises:
            SolverError: if no equilibrium is found on the way.
        """
        return heat_film(self.film(q), self._heated).hot_mm

    def linearise(self, q: np.ndarray, vertices_mm: np.ndarray) -> bool:
        """Prepare `push`, `pull` and `adjoint` at the equilibrium of q; False if it is not stable."""
        self._teach(q)
        return self._sensitivity.at(vertices_mm, q, self.activation)

    def push(self, dq: np.ndarray) -> np.ndarray:
        """Return how the vertices move [mm], shape [..., n, 3], for changes of the alignment, [..., layers, m, 2]."""
        return self._sensitivity.push(dq)

    def pull(self, by_vertices: np.ndarray) -> np.ndarray:
        """Return the gradients by the alignment of functions with these gradients by the vertices, [..., n, 3]."""
        return self._sensitivity.pull(by_vertices)

    def adjoint(self, by_vertices: np.ndarray) -> np.ndarray:
        """Return the adjoints of functions with these gradients by the vertices, shape [..., n, 3]."""
        return self._sensitivity.adjoint(by_vertices)

    def forces(self, q: np.ndarray, states_mm: Sequence[np.ndarray]) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return the derivatives of the energy by the vertices, [n, 3], and by the alignment, [layers, m, 2].

        The states, vertices [mm] of shape [n, 3] each, need not be in balance, and what was linearised stays.
        """
        self._teach(q)
        return self._sensitivity.forces(states_mm, q, self.activation)

    def _teach(self, q: np.ndarray) -> Shell:
        shell = self.newton.shell
        shell.teach(self.film(q), self.activation)
        return shell
