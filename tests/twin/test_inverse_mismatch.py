import numpy as np
import pytest

from planner.target import surface_mesh
from scenes.case import load_case
from twin.inverse.mismatch import Mismatch
from twin.score import score_surface


@pytest.fixture(scope="module")
def target():
    return load_case("face").make_target()


@pytest.fixture(scope="module")
def surface(target):
    return surface_mesh(target, 1.0)


def bump(points, amplitude_mm):
    """Displacement upwards that is no rigid motion."""
    x, y = points[:, 0], points[:, 1]
    height = amplitude_mm * np.sin(x / 4.0) * np.cos(y / 5.0)
    return np.column_stack((np.zeros((len(points), 2)), height))


def test_the_target_itself_is_not_off(target, surface):
    points, triangles = surface
    measured = Mismatch(target, triangles).measure(points)
    assert measured.ssim > 0.995
    assert measured.rms_mm < 0.02
    assert measured.outline_mm < 0.05


def test_it_is_the_score(target, surface):
    points, triangles = surface
    moved = points + bump(points, 0.3)
    measured, scored = Mismatch(target, triangles).measure(moved), score_surface(moved, triangles, target).score
    assert measured.ssim == pytest.approx(scored.ssim_eq4, abs=1e-9)
    # one is measured over pixels, the other over both surfaces
    assert measured.rms_mm == pytest.approx(scored.rms_mm, rel=0.1)


def test_the_model_predicts_what_a_step_gains(target, surface):
    points, triangles = surface
    mismatch = Mismatch(target, triangles)
    off = bump(points, 0.3)
    measured = mismatch.measure(points + off)
    for share in (0.3, 0.7):
        step = -share * off
        after = mismatch.measure(points + off + step, measured.transform)
        model = (measured.gradient * step).sum() + 0.5 * (step * measured.curve(step)).sum()
        assert after.value - measured.value == pytest.approx(model, rel=0.1)


def test_the_curvature_is_symmetric_and_positive_and_ignores_rigid_motion(target, surface):
    points, triangles = surface
    shape = points + bump(points, 0.3)
    measured = Mismatch(target, triangles).measure(shape)
    rng = np.random.default_rng(0)
    u, v = rng.normal(size=(2, *points.shape))
    assert (u * measured.curve(v)).sum() == pytest.approx((v * measured.curve(u)).sum(), rel=1e-9)
    assert (u * measured.curve(u)).sum() > 0.0
    up = np.zeros_like(points)
    up[:, 2] = 1.0
    tilt = np.cross((0.3, 0.2, 0.0), shape)
    for motion in (up, tilt):
        assert np.abs(measured.curve(motion)).max() < 1e-9 * np.abs(measured.curve(bump(points, 1.0))).max()
