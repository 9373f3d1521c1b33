"""What ties a design to its target beside the shape itself: the layers should want the target, bent a little further.

The energy that a film would have if it stood at the target with its curvature overdrawn by a factor,

    T(q) = sum over triangles of A W(a*, OVERBENDING b*; q),

needs no equilibrium. Where it is small the layers prefer the target's metric and more than its curvature. A heavy film
on a plate needs that: weight presses the target flat, and a film whose layers do not insist on the sense of every bend
turns some of them over on its way up from flat.

It is the curvature that keeps the sense of a bend. The metric may be given less weight: with the stiffness C of an
unloaded film in (a, b) and the stress s = (n, m) = dW/d(a, b) there,

    T(q) = sum over triangles of A (METRIC n C_a^-1 n + m C_b^-1 m) / 2,

which for METRIC = 1 and small differences is the same, but for what the layers disagree about among themselves. Where
the metric weighs little the film may be in tension here and in compression there, and that stiffens it.
"""

import numpy as np
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import KDTree

from twin.inverse.forms import edge_forms, frames, pull_back
from twin.inverse.layer_response import LayerResponse
from twin.shell.topology import stencils

OVERBENDING = 1.8
STIFFENING = 0.1
"""Weight of the metric that leaves layers room to stiffen the film, for robust designs."""
COMPLIANCE = np.linalg.inv(np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.0], [0.5, 0.0, 1.0]]))
"""Inverse of the second derivative of (d11^2 + d22^2 + d11 d22 + d12^2) / 2, see `Anchor.curve`."""


def forms_on_target(vertices_mm: np.ndarray, flat_mm: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the forms a*, b* of a film that stands at its target, shape [m, 6]: (11, 12, 22) of each.

    Args:
        vertices_mm: the film's mid-surface at the target [mm], shape [n, 3].
        flat_mm: the flat film [mm], shape [n, 2].
        triangles: vertex indices, shape [m, 3].
    """
    frame = frames(flat_mm, triangles)
    return np.hstack([pull_back(form, frame) for form in edge_forms(vertices_mm, triangles, stencils(triangles))])


def carry_forms(source_mm: np.ndarray, forms: np.ndarray, places_mm: np.ndarray) -> np.ndarray:
    """Interpolate forms between triangle centres of two meshes of a film, linearly: [k, 2], [k, 6], [m, 2] -> [m, 6].

    Carrying the vertices instead would crease them: a steep target moves far between two of them, and the forms of what
    lies between are then no film's.
    """
    carried = LinearNDInterpolator(source_mm, forms)(places_mm)
    outside = np.isnan(carried).any(axis=1)
    carried[outside] = forms[KDTree(source_mm).query(places_mm[outside])[1]]
    return carried


class Anchor:
    """The energy T(q) of a film, and its Gauss-Newton curvature."""

    def __init__(
        self,
        forms: np.ndarray,
        area_mm2: np.ndarray,
        layer_thickness_mm: np.ndarray,
        activation: float,
        *,
        hold: np.ndarray | None = None,
        metric: float = 1.0,
    ) -> None:
        """Prepare.

        Args:
            forms: a*, b* of each triangle, shape [m, 6], see `forms_on_target`.
            area_mm2: flat area of each triangle [mm^2], shape [m].
            layer_thickness_mm: flat thickness of each layer [mm], shape [layers].
            activation: fraction of the full contraction at which the film should be there.
            hold: factor on each triangle's share of the energy, shape [m]; None for 1.
            metric: weight of the metric beside the curvature's; 1 for the energy itself.
        """
        self._a, self._b = forms[:, :3], OVERBENDING * forms[:, 3:]
        self._metric, self._activation = metric, activation
        self._thickness = np.asarray(layer_thickness_mm, dtype=float)
        self.hold = np.ones(len(area_mm2)) if hold is None else hold
        """Factor on each triangle's share of the energy, shape [m]; may be replaced."""
        self._area = area_mm2
        self._response: np.ndarray = np.empty(0)

    def value(self, q: np.ndarray) -> tuple[float, np.ndarray]:
        """Return T over mu [mm^3] and its gradient, shape [layers, m, 2]."""
        response = LayerResponse(q, self._thickness, activation=self._activation)
        energy, area = response.energy(self._a, self._b), self.hold * self._area
        if self._metric == 1.0:
            return float(area @ energy.value), area[:, None] * energy.by_q
        strain = self._strain(energy.by_form)
        by_q = np.einsum("malq,ma->lmq", response.stress_by_q(self._a, self._b), area[:, None] * strain)
        return 0.5 * float(area @ (energy.by_form * strain).sum(axis=1)), by_q

    def linearise(self, q: np.ndarray) -> None:
        """Prepare `curve` at alignment vectors, shape [layers, m, 2]."""
        self._response = LayerResponse(q, self._thickness, activation=self._activation).stress_by_q(self._a, self._b)

    def curve(self, dq: np.ndarray) -> np.ndarray:
        """Return a positive semi-definite curvature of T times dq.

        T is about (f* - f) C (f* - f) / 2 = s C^-1 s / 2 with natural forms f, of which the square of the first
        derivative is kept.
        """
        strain = self._strain(np.einsum("malq,lmq->ma", self._response, dq))
        return np.einsum("malq,ma->lmq", self._response, (self.hold * self._area)[:, None] * strain)

    def _strain(self, stress: np.ndarray) -> np.ndarray:
        """Return C^-1 s, the metric's part times its weight, for stresses [m, 6]."""
        height = self._thickness.sum()
        # W = (d11^2 + d22^2 + d11 d22 + d12^2)/2 per thickness for a small change d of the metric at nu = 1/2
        metric, curvature = stress[:, :3] @ COMPLIANCE / height, 3.0 * stress[:, 3:] @ COMPLIANCE / height**3
        return np.hstack((self._metric * metric, curvature))
