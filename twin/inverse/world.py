"""One film of a design: what noise makes of its alignment, its equilibrium, and how that answers to the design."""

from dataclasses import dataclass

import numpy as np

from twin.film import Film, film_from_alignment
from twin.inverse.distortion import Distortion
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

    def __init__(
        self, film: Film, mismatch: Mismatch, heated: PredictOptions, distortion: Distortion | None = None
    ) -> None:
        """Prepare.

        Args:
            film: a film on the mesh; its alignment is replaced.
            mismatch: measures the shapes.
            heated: loads and temperature at which the film should have its shape.
            distortion: what the process makes of the intended alignment; None: exactly that.
        """
        self.newton = open_newton(film, heated)
        self._mismatch, self._heated = mismatch, heated
        self.distortion = distortion
        """What the process makes of the intended alignment; may be replaced, as long as `linearise` is called anew."""
        self._activation = ramp_end(heated)
        self._sensitivity = Sensitivity(self.newton)
        area = film.vertex_area_mm2
        self.vertex_share = (area / area.sum())[:, None]
        """Share of the film's area that belongs to each vertex, shape [n, 1]."""
        self._flat = np.column_stack((film.flat_mm, np.zeros(len(film.flat_mm))))

    def film(self, q: np.ndarray) -> Film:
        """Return the film whose triangles were meant to have the alignment q, shape [layers, m, 2]."""
        film = self.newton.shell.film
        return film_from_alignment(
            film.flat_mm,
            film.triangles,
            q if self.distortion is None else self.distortion.push(q),
            layer_thickness_mm=film.layer_thickness_mm,
            modulus_ratio=film.modulus_ratio,
        )

    def settle(self, q: np.ndarray, start_mm: np.ndarray, near: Shape | None = None) -> Shape:
        """Find the equilibrium near a start [mm], shape [n, 3], and measure it.

        Raises:
            SolverError: if there is none.
        """
        shell = self._teach(q)
        scale = shell.driving_force(self._flat)
        found = self.newton.solve(start_mm, force_scale=scale, tolerance=TOLERANCE)
        top = top_face(shell.film, found.vertices_mm, shell.top_mm)
        measured = self._mismatch.measure(top, None if near is None else near.measured.transform)
        return Shape(vertices_mm=found.vertices_mm, top_mm=top, measured=measured)

    def ramp(self, q: np.ndarray) -> np.ndarray:
        """Heat the film of q from flat as a prediction does; returns where it ends [mm], shape [n, 3].

        Raises:
            SolverError: if no equilibrium is found on the way.
        """
        return heat_film(self.film(q), self._heated).hot_mm

    def linearise(self, q: np.ndarray, shape: Shape) -> bool:
        """Prepare `push` and `pull` at the equilibrium of q; False if it is not stable."""
        self._teach(q)
        distorted = q if self.distortion is None else self.distortion.push(q)
        return self._sensitivity.at(shape.vertices_mm, distorted, self._activation)

    def push(self, dq: np.ndarray) -> np.ndarray:
        """Return how the vertices move [mm], shape [n, 3], for a change of the intended alignment."""
        return self._sensitivity.push(dq if self.distortion is None else self.distortion.push(dq))

    def pull(self, by_vertices: np.ndarray) -> np.ndarray:
        """Return the gradient by the intended alignment of a function with this gradient by the vertices [n, 3]."""
        by_q = self._sensitivity.pull(by_vertices)
        return by_q if self.distortion is None else self.distortion.pull(by_q)

    def _teach(self, q: np.ndarray) -> Shell:
        shell = self.newton.shell
        shell.teach(self.film(q), self._activation)
        return shell
