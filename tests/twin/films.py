"""Small films with known alignment for the twin's tests."""

import numpy as np

from planner.target import mesh_outline
from twin.film import Film, film_from_alignment
from twin.shell import Loads, Shell

PAPER_STACK_MM = (0.2, 0.2, 0.2, 0.2)


def rectangle(length_mm: float, width_mm: float) -> np.ndarray:
    """Outline of a rectangle centred on the origin, length along x [mm], shape [4, 2]."""
    x, y = length_mm / 2, width_mm / 2
    return np.array([[-x, -y], [x, -y], [x, y], [-x, y]])


def ellipse(radius_x_mm: float, radius_y_mm: float, points: int = 180) -> np.ndarray:
    """Outline of an ellipse [mm], shape [points, 2]."""
    angle = np.linspace(0, 2 * np.pi, points, endpoint=False)
    return np.column_stack((radius_x_mm * np.cos(angle), radius_y_mm * np.sin(angle)))


def film(outline, mesh_mm, *, layers=(0, 1), contraction=0.0, direction=None) -> Film:
    """Film whose `layers` contract by `contraction` along `direction` (a function of centroids -> angle)."""
    flat, triangles = mesh_outline(outline, mesh_mm)
    centre = flat[triangles].mean(axis=1)
    angle = np.zeros(len(triangles)) if direction is None else direction(centre)
    q = np.zeros((len(PAPER_STACK_MM), len(triangles), 2))
    q[list(layers)] = contraction * np.column_stack((np.cos(2 * angle), np.sin(2 * angle)))
    return film_from_alignment(flat, triangles, q, layer_thickness_mm=np.array(PAPER_STACK_MM))


def azimuthal(centre: np.ndarray) -> np.ndarray:
    """Direction of circles around the origin [rad], shape [m, 2] -> [m]."""
    return np.arctan2(centre[:, 1], centre[:, 0]) + np.pi / 2


def random_film(rng: np.random.Generator, *, activation: float = 1.0, loads: Loads | None = None):
    """Shell of a small film with four random layers, and a bent state of it [mm], shape [n, 3]."""
    flat, triangles = mesh_outline(rectangle(6.0, 5.0), 1.0)
    q = 0.25 * rng.normal(size=(4, len(triangles), 2))
    made = film_from_alignment(flat, triangles, np.clip(q, -0.3, 0.3), layer_thickness_mm=np.array(PAPER_STACK_MM))
    shell = Shell(made, loads=loads, device="cpu")
    shell.set_activation(activation)
    state = np.column_stack((flat, 0.3 * np.sin(flat[:, 0]) * np.cos(flat[:, 1])))
    return shell, state + 0.03 * rng.normal(size=state.shape)


def reference_shell(data, name: str) -> Shell:
    """Fully activated shell of one of the reference films; those on the plate carry its loads."""
    made = Film(
        flat_mm=data["flat_mm"],
        triangles=data["triangles"],
        layer_thickness_mm=np.full(4, 0.2),
        director_rad=data["director_rad"],
        contraction=data["contraction"],
        modulus_ratio=np.ones(4),
    )
    modulus_mpa = float(data["modulus_mpa"])
    loads = Loads(weight=1.1772e-5 * 0.8 / (modulus_mpa / 3), plate_per_mm=1.0) if "plate" in name else None
    shell = Shell(made, loads=loads, device="cpu")
    shell.set_activation(1.0)
    return shell
