import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from planner.target import target_from_heights
from twin.scan import grid_triangles, register


def bumpy_target(step_mm=0.4):
    """A face-like relief: a dome with a nose off the middle and two hollows, different on each side."""
    x, y = np.arange(-16, 16 + step_mm / 2, step_mm), np.arange(-24, 24 + step_mm / 2, step_mm)
    X, Y = np.meshgrid(x, y)

    def bump(x0, y0, rx, ry, height):
        return height * np.exp(-(((X - x0) / rx) ** 2) - ((Y - y0) / ry) ** 2)

    z = 12 * np.sqrt(np.maximum(1.25 - (X / 18) ** 2 - (Y / 27) ** 2, 0))
    z = z + bump(0, -2, 4, 6, 5) - bump(-6, 6, 4, 3, 2) - bump(6, 6, 4, 3, 2.5) + bump(0, -12, 5, 2, 1.5)
    return target_from_heights("relief", x, y, np.where((X / 16) ** 2 + (Y / 24) ** 2 <= 1, z, np.nan))


@pytest.fixture(scope="module")
def target():
    return bumpy_target()


@pytest.fixture(scope="module")
def mesh(target):
    return grid_triangles(target.x_mm, target.y_mm, target.z_mm)


def assert_proper(rotation):
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1.0)


def test_any_orientation_of_a_scan_is_found(target, mesh):
    vertices, triangles = mesh
    turn = Rotation.random(random_state=2)
    motion = register(turn.apply(vertices) + np.array([30, -20, 55]), target, triangles=triangles)
    assert_proper(motion.rotation)
    assert np.abs(motion.apply(turn.apply(vertices) + np.array([30, -20, 55])) - vertices).max() < 0.01


def test_a_nearly_right_frame_is_found_without_the_search(target, mesh):
    vertices, triangles = mesh
    turn = Rotation.from_euler("xyz", [17, -14, 6], degrees=True)
    moved = turn.apply(vertices) + np.array([4, -3, 2])
    motion = register(moved, target, triangles=triangles, coarse=False)
    assert_proper(motion.rotation)
    assert np.abs(motion.apply(moved) - vertices).max() < 0.01


@pytest.mark.parametrize("cloud", [True, False])
def test_noise_and_a_fifth_missing(target, mesh, cloud):
    vertices, triangles = mesh
    rng = np.random.default_rng(4)
    turn = Rotation.random(random_state=5)
    noisy = turn.apply(vertices + rng.normal(0, 0.15, vertices.shape))
    distance = np.linalg.norm(vertices - vertices[len(vertices) // 7], axis=1)
    kept = distance > np.quantile(distance, 0.2)
    if cloud:
        motion = register(noisy[kept], target)
    else:
        motion = register(noisy, target, triangles=triangles[kept[triangles].all(axis=1)])
    assert np.abs(motion.apply(turn.apply(vertices)) - vertices).max() < 0.1


@pytest.mark.parametrize("share", [0.05, 0.3])
def test_a_shallow_film_stays_in_the_middle(target, mesh, share):
    vertices, triangles = mesh
    shallow = vertices * [1, 1, share]
    turn = Rotation.from_euler("xyz", [8, -12, 0], degrees=True)
    motion = register(turn.apply(shallow) + np.array([5, 4, 1]), target, triangles=triangles, coarse=False)
    moved = motion.apply(turn.apply(shallow) + np.array([5, 4, 1]))
    # Neither under a wall nor on its edge: the outline stays within 2 mm of the target's.
    assert np.abs(moved[:, :2].mean(axis=0) - vertices[:, :2].mean(axis=0)).max() < 1.5
    assert np.linalg.norm(moved[:, :2] - shallow[:, :2], axis=1).max() < 3.0
    # And centred in height, not below or above.
    assert abs(moved[:, 2].mean() - vertices[:, 2].mean()) < 1.5


def test_a_scale_is_not_corrected(target, mesh):
    vertices, triangles = mesh
    motion = register(1.2 * vertices, target, triangles=triangles, coarse=False)
    assert_proper(motion.rotation)
    assert motion.residual_mm > 0.5


def test_the_same_answer_every_time(target, mesh):
    vertices, triangles = mesh
    turned = Rotation.from_euler("xyz", [9, 4, 2], degrees=True).apply(vertices)
    first, second = (register(turned, target, triangles=triangles, coarse=False) for _ in range(2))
    np.testing.assert_array_equal(first.rotation, second.rotation)
    np.testing.assert_array_equal(first.translation_mm, second.translation_mm)
