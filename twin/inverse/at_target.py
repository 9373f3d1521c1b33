"""First design: the flat film and the alignment that have the least elastic energy when bent into the target.

No equilibrium is solved. The film's vertices stand at the target, so that the forms on the edge vectors are constants;
unknown are where the vertices lie on the flat film, and the alignment of each layer. Where the energy could be brought
to zero the target would be a stress-free state of the heated film. Energies are weighed by the target's area: by the
film's, the film would shrink.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from planner.flattening import flatten
from planner.target import Target
from twin.inverse.anchor import OVERBENDING
from twin.inverse.field_control import FieldControl, Stack
from twin.inverse.forms import edge_forms, frames, pull_back
from twin.inverse.layer_response import LayerResponse
from twin.shell.topology import stencils

FLAT_SCALE = 1.1
"""Size of the first flat film over the flattened target: a film only contracts."""
SMOOTHNESS = 1e-2
START_CONTRACTION = 0.02
MEMORY = 20


@dataclass(frozen=True, kw_only=True, eq=False)
class FirstDesign:
    """A flat film with alignment, and where it would be on the target."""

    flat_mm: np.ndarray
    """Vertices of the flat film [mm], shape [n, 2]."""
    triangles: np.ndarray
    """Vertex indices, shape [m, 3]."""
    u: np.ndarray
    """Design variables of a `FieldControl`, shape [layers, n, 2]."""
    vertices_mm: np.ndarray
    """Mid-surface on the target [mm], shape [n, 3]."""
    energy_mm: float
    """Mean elastic energy per area over mu [mm]."""


class TargetEnergy:
    """Energy of a film whose vertices stand at given places, as a function of the flat film and of the alignment."""

    def __init__(
        self,
        vertices_mm: np.ndarray,
        triangles: np.ndarray,
        layer_thickness_mm: np.ndarray,
        control: FieldControl,
        *,
        activation: float = 1.0,
        overbending: float = 1.0,
    ) -> None:
        """Prepare.

        Args:
            vertices_mm: mid-surface [mm], shape [n, 3].
            triangles: vertex indices, shape [m, 3].
            layer_thickness_mm: flat thickness of each layer [mm], shape [layers].
            control: design variables of the alignment.
            activation: fraction of the full contraction.
            overbending: factor on the second form, see `twin.inverse.anchor`.
        """
        self._triangles, self._thickness, self._control = triangles, layer_thickness_mm, control
        self._activation = activation
        self._first, second = edge_forms(vertices_mm, triangles, stencils(triangles))
        self._second = overbending * second
        corners = vertices_mm[triangles]
        vector = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.area_mm2 = 0.5 * np.linalg.norm(vector, axis=1)

    def __call__(self, flat_mm: np.ndarray, u: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """Return energy over mu [mm^3] plus penalty, and its gradients by the flat vertices and by u."""
        frame = frames(flat_mm, self._triangles)
        a, b = pull_back(self._first, frame), pull_back(self._second, frame)
        energy = LayerResponse(self._control.q(u), self._thickness, activation=self._activation).energy(a, b)
        penalty, by_u = self._control.penalty(u)
        weight = self.area_mm2[:, None]
        by_u = by_u + self._control.pull(u, weight * energy.by_q)
        by_flat = _by_flat(self._triangles, len(flat_mm), frame, a, b, weight * energy.by_form)
        return float(self.area_mm2 @ energy.value) + penalty, by_flat, by_u


def design_at_target(
    target: Target,
    *,
    edge_mm: float,
    layer_thickness_mm: np.ndarray,
    largest: float,
    stack: Stack = "all",
    activation: float = 1.0,
    overbending: float = OVERBENDING,
    iterations: int = 300,
    seed: int = 0,
) -> FirstDesign:
    """Return the film that fits the target best without asking whether it stays there.

    Args:
        target: the surface that the top face should become.
        edge_mm: edge length of the triangles, seen from above on the target [mm].
        layer_thickness_mm: flat thickness of each layer [mm], shape [layers].
        largest: largest contraction that a layer can be given.
        stack: which layers have fields of their own, see `FieldControl`.
        activation: fraction of the full contraction at which the film should be there.
        overbending: factor on the target's second form, see `twin.inverse.anchor`.
        iterations: steps of L-BFGS.
        seed: of the small random alignment to start from.

    Raises:
        InputError: if the target cannot be laid flat or meshed.
    """
    flattening = flatten(target, edge_mm=edge_mm)
    triangles, count = flattening.triangles, len(flattening.vertices_mm)
    vertices = _below(flattening.vertices_mm, triangles, 0.5 * float(np.sum(layer_thickness_mm)))
    control = FieldControl(
        triangles,
        count,
        layers=len(layer_thickness_mm),
        stack=stack,
        largest=largest,
        smoothness=SMOOTHNESS,
        damping=1.0,
    )
    energy, shape = (
        TargetEnergy(vertices, triangles, layer_thickness_mm, control, activation=activation, overbending=overbending),
        (control.fields, count, 2),
    )

    def value(unknown: np.ndarray) -> tuple[float, np.ndarray]:
        flat, u = unknown[: 2 * count].reshape(count, 2), unknown[2 * count :].reshape(shape)
        total, by_flat, by_u = energy(flat, u)
        return total, np.concatenate((by_flat.ravel(), by_u.ravel()))

    rng = np.random.default_rng(seed)
    alignment = START_CONTRACTION * rng.normal(size=shape)
    start = np.concatenate((FLAT_SCALE * flattening.film_mm.ravel(), alignment.ravel()))
    options = {"maxiter": iterations, "maxcor": MEMORY, "maxfun": 2 * iterations}
    found = minimize(value, start, jac=True, method="L-BFGS-B", options=options)
    u = found.x[2 * count :].reshape(shape)
    return FirstDesign(
        flat_mm=found.x[: 2 * count].reshape(count, 2),
        triangles=triangles,
        u=u,
        vertices_mm=vertices,
        energy_mm=(float(found.fun) - control.penalty(u)[0]) / float(energy.area_mm2.sum()),
    )


def _below(top_mm: np.ndarray, triangles: np.ndarray, depth_mm: float) -> np.ndarray:
    """Return the surface `depth_mm` below another along its vertex normals."""
    corners = top_mm[triangles]
    vector = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal = np.stack([np.bincount(triangles.ravel(), np.repeat(part, 3), len(top_mm)) for part in vector.T], axis=1)
    return top_mm - depth_mm * normal / np.linalg.norm(normal, axis=1, keepdims=True)


def _by_flat(
    triangles: np.ndarray, count: int, frame: np.ndarray, a: np.ndarray, b: np.ndarray, by_form: np.ndarray
) -> np.ndarray:
    """Return the gradient by the flat vertices, shape [n, 2], from that by the pulled back forms, shape [m, 6].

    With the flat edge matrix E, its inverse T and symmetric S, a = T^t I T changes with E by
    S : da = -2 tr(T S a dE).
    """
    product = _full(by_form[:, :3], 0.5) @ _full(a) + _full(by_form[:, 3:], 0.5) @ _full(b)
    by_edges = -2.0 * (frame @ product).swapaxes(1, 2)
    by_corner = (-by_edges.sum(axis=2), by_edges[:, :, 0], by_edges[:, :, 1])
    flat = np.zeros((count, 2))
    for corner, part in enumerate(by_corner):
        for axis in range(2):
            flat[:, axis] += np.bincount(triangles[:, corner], part[:, axis], count)
    return flat


def _full(form: np.ndarray, off_diagonal: float = 1.0) -> np.ndarray:
    """Return symmetric tensors as matrices, shape [m, 3] -> [m, 2, 2]."""
    mixed = off_diagonal * form[:, 1]
    return np.stack((np.stack((form[:, 0], mixed), axis=1), np.stack((mixed, form[:, 2]), axis=1)), axis=1)
