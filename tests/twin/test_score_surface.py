import dataclasses

import numpy as np
import pytest

from planner.errors import InputError
from planner.target import surface_mesh, target_from_heights
from twin.scan import Scanner
from twin.score import score_surface


@pytest.fixture(scope="module")
def target():
    x, y = np.arange(-16, 16.1, 0.25), np.arange(-22, 22.1, 0.25)
    X, Y = np.meshgrid(x, y)
    z = 10 * np.sqrt(np.maximum(1.2 - (X / 18) ** 2 - (Y / 25) ** 2, 0))
    z = z + 5 * np.exp(-((X / 4) ** 2) - ((Y + 2) / 6) ** 2) - 2 * np.exp(-(((X - 6) / 4) ** 2) - ((Y - 7) / 3) ** 2)
    return target_from_heights("relief", x, y, np.where((X / 16) ** 2 + (Y / 22) ** 2 <= 1, z, np.nan))


@pytest.fixture(scope="module")
def mesh(target):
    return surface_mesh(target, 0.4)


def test_the_names_are_the_contract(target, mesh):
    names = [field.name for field in dataclasses.fields(score_surface(*mesh, target).score)]
    assert names == [
        "ssim_eq4",
        "ssim_eq4_own_scale",
        "ssim_eq4_inside",
        "ssim_gauss",
        "rms_mm",
        "rms_percent_of_diagonal",
        "hausdorff_mm",
        "depth_mm",
        "target_depth_mm",
    ]


def test_a_target_against_itself(target, mesh):
    scored = score_surface(*mesh, target)
    score = scored.score
    assert score.ssim_eq4 == pytest.approx(1.0, abs=2e-3)
    assert score.ssim_eq4_inside == pytest.approx(1.0, abs=1e-4)
    assert score.ssim_gauss == pytest.approx(1.0, abs=2e-2)
    assert score.rms_mm < 0.02
    assert score.hausdorff_mm < 0.4
    assert score.depth_mm == pytest.approx(target.depth_mm, abs=0.05)
    assert scored.ssim_map.shape == scored.shape_depth_mm.shape == (168, 104)


def test_height_error_is_hidden_by_the_own_scale_only(target, mesh):
    vertices, triangles = mesh
    score = score_surface(vertices * [1, 1, 0.6], triangles, target).score
    assert score.ssim_eq4 < score.ssim_eq4_own_scale - 0.02
    assert score.depth_mm == pytest.approx(0.6 * target.depth_mm, rel=0.15)
    assert score.rms_mm > 0.5
    assert score.rms_percent_of_diagonal == pytest.approx(100 * score.rms_mm / target.diagonal_mm)


def test_the_sign_of_the_error_is_up(target, mesh):
    vertices, triangles = mesh
    bump = np.exp(-((vertices[:, 0] / 3) ** 2) - ((vertices[:, 1] - 8) / 3) ** 2)
    scored = score_surface(vertices + np.outer(bump, [0, 0, 1.0]), triangles, target)
    worst = np.argmax(np.abs(scored.error_mm))
    assert scored.error_mm[worst] > 0.7
    assert bump[worst] > 0.7


def test_a_cloud_scores_as_its_surface(target, mesh):
    vertices, _ = mesh
    score = score_surface(vertices + np.array([3, -2, 7]), None, target, coarse=True).score
    assert score.ssim_eq4 > 0.98
    assert score.rms_mm < 0.05


def test_a_virtual_scan_costs_some_of_the_score(target, mesh):
    scan = Scanner().scan(*mesh, np.random.default_rng(0))
    score = score_surface(scan.vertices_mm, scan.triangles, target, coarse=True).score
    assert 0.6 < score.ssim_eq4 < 0.97
    assert 0.1 < score.rms_mm < 0.6


def test_a_surface_that_is_not_finite_is_refused(target, mesh):
    vertices, triangles = mesh
    with pytest.raises(InputError, match="not finite"):
        score_surface(np.where(vertices > 5, np.nan, vertices), triangles, target)


@pytest.mark.shared
def test_the_shared_face_against_its_own_scan_file(shared_dir):
    from twin.scan import read_scan

    data = np.load(shared_dir / "targets" / "ict_mean.npz")
    target = target_from_heights("face", data["x_mm"], data["y_mm"], data["z_mm"])
    scan = read_scan(shared_dir / "targets" / "ict_mean.stl")
    score = score_surface(scan.vertices_mm, scan.triangles, target, coarse=True).score
    assert score.ssim_eq4 > 0.98
    assert score.rms_mm < 0.05
