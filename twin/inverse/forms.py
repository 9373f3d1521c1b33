"""Fundamental forms of a triangle mesh from its mid-edge normals; equations in docs of twin.shell.kernels."""

import numpy as np

from twin.shell.topology import Stencils


def edge_forms(vertices_mm: np.ndarray, triangles: np.ndarray, around: Stencils) -> tuple[np.ndarray, np.ndarray]:
    """Return first and second form on the edge vectors e1 = q1 - q0, e2 = q2 - q0, each (11, 12, 22), [m, 3].

    Args:
        vertices_mm: vertices [mm], shape [n, 3].
        triangles: vertex indices, shape [m, 3].
        around: neighbours of the triangles.
    """
    corners = vertices_mm[triangles]
    e1, e2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(e1, e2)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    neighbour = np.where((around.across >= 0)[..., None], normal[around.across], normal[:, None])
    middle = normal[:, None] + neighbour
    middle /= np.linalg.norm(middle, axis=2, keepdims=True)
    first = np.stack([(u * v).sum(axis=1) for u, v in ((e1, e1), (e1, e2), (e2, e2))], axis=1)
    b12 = -2.0 * (middle[:, 0] * e1).sum(axis=1)
    b11 = b12 + 2.0 * (middle[:, 1] * e1).sum(axis=1)
    b22 = 2.0 * ((middle[:, 2] - middle[:, 0]) * e2).sum(axis=1)
    return first, np.stack((b11, b12, b22), axis=1)


def pull_back(form: np.ndarray, frame: np.ndarray) -> np.ndarray:
    """Express forms on the edge vectors in the orthonormal frame: T^t I T, shapes [m, 3] and [m, 2, 2] -> [m, 3]."""
    (x1, y1), (x2, y2) = frame[:, 0].T, frame[:, 1].T
    i11, i12, i22 = form.T
    pulled = (
        i11 * x1 * x1 + 2.0 * i12 * x1 * x2 + i22 * x2 * x2,
        i11 * x1 * y1 + i12 * (x1 * y2 + x2 * y1) + i22 * x2 * y2,
        i11 * y1 * y1 + 2.0 * i12 * y1 * y2 + i22 * y2 * y2,
    )
    return np.stack(pulled, axis=1)


def frames(flat_mm: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the inverse of each triangle's flat edge matrix [e1 e2] [1/mm], shape [m, 2, 2]."""
    p = flat_mm[triangles]
    return np.linalg.inv(np.stack((p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=-1))
