import numpy as np
import pytest
import trimesh

from planner.errors import InputError
from twin.scan import Scanner, grid_points, grid_triangles, read_scan

X, Y = np.linspace(-8, 8, 33), np.linspace(-10, 10, 41)
Z = 6 - 0.05 * X[None, :] ** 2 - 0.03 * Y[:, None] ** 2
VERTICES, TRIANGLES = grid_triangles(X, Y, Z)


@pytest.mark.parametrize("suffix", [".stl", ".ply", ".obj"])
def test_meshes(tmp_path, suffix):
    path = tmp_path / f"scan{suffix}"
    trimesh.Trimesh(VERTICES, TRIANGLES, process=False).export(path)
    scan = read_scan(path)
    assert scan.triangles is not None
    assert len(scan.triangles) == len(TRIANGLES)
    np.testing.assert_allclose(scan.vertices_mm.min(axis=0), VERTICES.min(axis=0), atol=1e-5)
    np.testing.assert_allclose(scan.vertices_mm.max(axis=0), VERTICES.max(axis=0), atol=1e-5)


def test_clouds(tmp_path):
    trimesh.PointCloud(VERTICES).export(tmp_path / "cloud.ply")
    np.savetxt(tmp_path / "cloud.xyz", np.column_stack([VERTICES, VERTICES]), fmt="%.6f")
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in VERTICES]
    (tmp_path / "cloud.obj").write_text("\n".join(["# phone", *lines]))
    np.savez(tmp_path / "cloud.npz", vertices_mm=VERTICES)
    for suffix in ("ply", "xyz", "obj", "npz"):
        scan = read_scan(tmp_path / f"cloud.{suffix}")
        assert scan.triangles is None
        np.testing.assert_allclose(scan.vertices_mm, VERTICES, atol=1e-5)


def test_height_grids(tmp_path):
    heights = Z.copy()
    heights[:5] = np.nan
    np.savez(tmp_path / "grid.npz", x_mm=X, y_mm=Y, z_mm=heights)
    scan = read_scan(tmp_path / "grid.npz")
    assert len(scan.vertices_mm) == 36 * 33
    assert scan.triangles is not None
    assert len(scan.triangles) == 2 * 35 * 32


def test_points_that_are_no_numbers_are_left_out_with_a_note(tmp_path):
    vertices = VERTICES.copy()
    vertices[7] = np.nan
    np.savez(tmp_path / "scan.npz", vertices_mm=vertices, triangles=TRIANGLES)
    scan = read_scan(tmp_path / "scan.npz")
    assert len(scan.vertices_mm) == len(VERTICES) - 1
    assert scan.triangles is not None
    assert scan.triangles.max() == len(scan.vertices_mm) - 1
    assert "1 points" in scan.notes[0]


def test_what_is_no_scan_is_refused_in_one_sentence(tmp_path):
    def problem(name):
        with pytest.raises(InputError) as caught:
            read_scan(tmp_path / name)
        assert len(caught.value.problems) == 1
        return str(caught.value)

    assert "no such file" in problem("absent.stl")
    (tmp_path / "scan.step").write_text("x")
    assert ".stl" in problem("scan.step")
    for suffix in ("stl", "ply", "xyz", "npz", "obj"):
        (tmp_path / f"broken.{suffix}").write_text("nothing of use")
        assert f"broken.{suffix}" in problem(f"broken.{suffix}")
    np.savez(tmp_path / "keys.npz", height=Z)
    assert "x_mm" in problem("keys.npz")
    np.savez(tmp_path / "shape.npz", x_mm=Y, y_mm=X, z_mm=Z)
    assert "shape" in problem("shape.npz")
    np.savez(tmp_path / "metres.npz", vertices_mm=VERTICES / 1000)
    assert "1000" in problem("metres.npz")
    np.savez(tmp_path / "huge.npz", vertices_mm=VERTICES * 1000)
    assert "mm wide" in problem("huge.npz")
    np.savez(tmp_path / "few.npz", vertices_mm=VERTICES[:20])
    assert "20 points" in problem("few.npz")
    np.savez(tmp_path / "index.npz", vertices_mm=VERTICES, triangles=TRIANGLES + 5)
    assert "triangle" in problem("index.npz")
    np.savez(tmp_path / "flat.npz", vertices_mm=VERTICES[:, :2])
    assert "shape" in problem("flat.npz")


def test_a_cloud_becomes_a_surface_without_bridges():
    rng = np.random.default_rng(0)
    xy = rng.uniform(-10, 10, (6000, 2))
    xy = xy[np.hypot(*xy.T) > 4]
    vertices, triangles = grid_points(np.column_stack([xy, 0.1 * xy[:, 0]]))
    a, b, c = (vertices[triangles[:, i], :2] for i in range(3))
    area = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    assert area.min() > 0
    # The square with a round hole: 400 - 16 pi.
    assert area.sum() == pytest.approx(400 - 16 * np.pi, rel=0.03)


def test_the_virtual_scanner_has_the_errors_it_promises():
    scanner, rng = Scanner(), np.random.default_rng(1)
    fields = np.stack([scanner.errors((60, 80), rng) for _ in range(60)])
    assert fields.std() == pytest.approx(np.hypot(0.4, 0.15), rel=0.1)
    # Pixels 7 mm apart: the bias has fallen to 1/e.
    lag = round(7.0 / scanner.pixel_mm)
    covariance = np.mean(fields[:, :, lag:] * fields[:, :, :-lag])
    assert covariance == pytest.approx(0.16 * np.exp(-((lag * 0.4 / 7.0) ** 2)), abs=0.03)
    # Neighbours differ by noise alone, nearly.
    assert np.diff(fields, axis=2).std() == pytest.approx(np.sqrt(2) * 0.15, rel=0.1)


def test_the_virtual_scanner_sees_the_surface():
    scan = Scanner(bias_rms_mm=0.0, noise_rms_mm=0.0).scan(VERTICES, TRIANGLES, np.random.default_rng(0))
    x, y, z = scan.vertices_mm.T
    np.testing.assert_allclose(z, 6 - 0.05 * x**2 - 0.03 * y**2, atol=0.01)
