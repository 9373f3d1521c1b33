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


def design_at_target(
    target: Target,
    *,
    edge_mm: float,
    layer_thickness_mm: np.ndarray,
    largest: float,
    stack: Stack = "all",
    iterations: int = 300,
    seed: int = 0,
) -> FirstDesign:
    """Return the film that fits the target best without asking whether it stays there.

    Args:
        target: the surface that the top face should become.
        edge_mm: edge length of the triangles, seen from above on the target [mm].
        layer_thickness_mm: flat thickness of each layer [mm], shape [L].
        largest: largest contraction that a layer can be given.
        stack: which layers have fields of their own, see `FieldControl`.
        iterations: steps of L-BFGS.
        seed: of the small random alignment to start from.

    Raises:
        InputError: if the target cannot be laid flat or meshed.
    """
    flattening = flatten(target, edge_mm=edge_mm)
    triangles, count = flattening.triangles, len(flattening.vertices_mm)
    vertices, area = _mid_surface(flattening.vertices_mm, triangles, 0.5 * float(np.sum(layer_thickness_mm)))
    first, second = edge_forms(vertices, triangles, stencils(triangles))
    control = FieldControl(
        triangles,
        count,
        layers=len(layer_thickness_mm),
        stack=stack,
        largest=largest,
        smoothness=SMOOTHNESS,
        damping=1.0,
    )
    fields = control.fields

    def value(unknown: np.ndarray) -> tuple[float, np.ndarray]:
        flat, u = unknown[: 2 * count].reshape(count, 2), unknown[2 * count :].reshape(fields, count, 2)
        frame = frames(flat, triangles)
        a, b = pull_back(first, frame), pull_back(second, frame)
        energy = LayerResponse(control.q(u), layer_thickness_mm).energy(a, b)
        penalty, by_u = control.penalty(u)
        by_u = by_u + control.pull(u, area[:, None] * energy.by_q)
        by_flat = _by_flat(triangles, count, frame, a, b, area[:, None] * energy.by_form)
        return float(area @ energy.value) + penalty, np.concatenate((by_flat.ravel(), by_u.ravel()))

    rng = np.random.default_rng(seed)
    start = np.concatenate(
        (FLAT_SCALE * flattening.film_mm.ravel(), START_CONTRACTION * rng.normal(size=2 * fields * count))
    )
    options = {"maxiter": iterations, "maxcor": MEMORY, "maxfun": 2 * iterations}
    found = minimize(value, start, jac=True, method="L-BFGS-B", options=options)
    u = found.x[2 * count :].reshape(fields, count, 2)
    return FirstDesign(
        flat_mm=found.x[: 2 * count].reshape(count, 2),
        triangles=triangles,
        u=u,
        vertices_mm=vertices,
        energy_mm=(float(found.fun) - control.penalty(u)[0]) / float(area.sum()),
    )


def _mid_surface(top_mm: np.ndarray, triangles: np.ndarray, depth_mm: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the surface `depth_mm` below another along its vertex normals, and the area of its triangles."""
    corners = top_mm[triangles]
    vector = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal = np.stack([np.bincount(triangles.ravel(), np.repeat(part, 3), len(top_mm)) for part in vector.T], axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return top_mm - depth_mm * normal, 0.5 * np.linalg.norm(vector, axis=1)


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
