import imageio.v3 as iio
import numpy as np
import pytest
import trimesh

from planner.errors import InputError
from planner.target import Surface, load_target, save_target, target_from_heights
from planner.target.up_axis import ROTATIONS


def bumps(cell=0.25):
    """Heights without any symmetry, so that a mirrored or turned reader shows."""
    x, y = np.arange(-10.0, 10.01, cell), np.arange(-15.0, 15.01, cell)
    X, Y = np.meshgrid(x, y)
    z = 3 * np.exp(-((X - 3) ** 2 + (Y - 8) ** 2) / 8) + 0.05 * X + 2.0 * np.cos(Y / 12) + np.exp(-((X + 4) ** 2))
    z[(X / 10) ** 2 + (Y / 15) ** 2 > 1] = np.nan
    return x, y, z


@pytest.fixture(scope="module")
def target():
    return target_from_heights("bumps", *bumps())


def sheet(target, step=2):
    """Open mesh over every second node of the target's grid."""
    x, y, z = target.x_mm[::step], target.y_mm[::step], target.z_mm[::step, ::step]
    index = np.arange(z.size).reshape(z.shape)
    a, b, c, d = (index[s] for s in (np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, 1:], np.s_[1:, :-1]))
    triangles = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    vertices = np.column_stack([g.ravel() for g in (*np.meshgrid(x, y), z)])
    triangles = triangles[np.isfinite(vertices[triangles]).all(axis=(1, 2))]
    used, renumbered = np.unique(triangles, return_inverse=True)
    return vertices[used], renumbered.reshape(-1, 3)


def write_mesh(path, vertices, triangles):
    trimesh.Trimesh(vertices, triangles, process=False).export(path)
    return path


def assert_same_surface(found, expected, tolerance, share=0.98):
    points = np.stack(np.meshgrid(np.linspace(-9, 9, 50), np.linspace(-14, 14, 60)), axis=-1)
    difference = Surface(found).height(points) - Surface(expected).height(points)
    difference = np.abs(difference - np.nanmedian(difference))
    difference = difference[np.isfinite(difference)]
    assert difference.size > 1500
    assert np.quantile(difference, share) < tolerance


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply", "glb", "off"])
def test_meshes_of_all_formats_give_the_same_surface(tmp_path, target, suffix):
    found = load_target(write_mesh(tmp_path / f"face.{suffix}", *sheet(target)))
    assert found.name == "face"
    assert found.notes == ()
    assert_same_surface(found, target, 0.05)
    assert found.size_mm == pytest.approx(target.size_mm, abs=1.0)


@pytest.mark.parametrize("up", list(ROTATIONS))
def test_the_up_axis_turns_without_mirroring(tmp_path, target, up):
    rotation = np.array(ROTATIONS[up], dtype=float)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    axis = {"x": 0, "y": 1, "z": 2}[up[1]]
    assert rotation[2, axis] == (1 if up[0] == "+" else -1)
    vertices, triangles = sheet(target)
    path = write_mesh(tmp_path / "turned.ply", vertices @ rotation, triangles)
    assert_same_surface(load_target(path, up=up), target, 0.05)


def test_a_closed_solid_may_have_its_underside(tmp_path):
    trimesh.creation.icosphere(4, radius=10).export(tmp_path / "ball.stl")
    ball = load_target(tmp_path / "ball.stl")
    assert ball.notes == ()
    assert ball.size_mm == pytest.approx((20, 20), abs=0.2)
    assert Surface(ball).height(np.array([[0, 0], [6, 0]])) == pytest.approx([10, 8], abs=0.05)


def test_size_scales_all_axes_alike(tmp_path, target):
    path = write_mesh(tmp_path / "face.stl", *sheet(target))
    whole, half = load_target(path), load_target(path, size_mm=(9.0, 100.0))
    assert half.size_mm[0] == pytest.approx(9.0)
    factor = 9.0 / whole.size_mm[0]
    assert half.size_mm[1] == pytest.approx(factor * whole.size_mm[1], rel=0.02)
    assert half.depth_mm == pytest.approx(factor * whole.depth_mm, rel=0.02)
    assert any("scaled by 0.4" in note for note in half.notes)


@pytest.mark.parametrize(("factor", "size"), [(1000.0, "2e+04 x"), (0.001, "0.02 x")])
def test_wrong_units_are_refused_and_mended_by_a_size(tmp_path, target, factor, size):
    vertices, triangles = sheet(target)
    path = write_mesh(tmp_path / "face.stl", vertices * factor, triangles)
    with pytest.raises(InputError, match="--size-mm 40x60") as caught:
        load_target(path)
    assert "allowed are 2 to 300 mm" in str(caught.value)
    assert load_target(path, size_mm=(20, 30)).size_mm == pytest.approx((20, 30), rel=0.02)
    for bad in [(0.0, 30.0), (40.0, 4000.0), (np.nan, 3.0)]:
        with pytest.raises(InputError, match="each side must be"):
            load_target(path, size_mm=bad)


def test_a_saved_target_comes_back_exactly(tmp_path, target):
    save_target(target, tmp_path / "kept.npz")
    kept = load_target(tmp_path / "kept.npz")
    assert (kept.digest, kept.name, kept.notes) == (target.digest, target.name, target.notes)
    assert np.array_equal(kept.outline_mm, target.outline_mm)
    assert [path.name for path in tmp_path.iterdir()] == ["kept.npz"]
    assert load_target(tmp_path / "kept.npz", name="other").name == "other"
    small = load_target(tmp_path / "kept.npz", size_mm=(10, 10))
    assert max(small.size_mm) == pytest.approx(10)
    save_target(small, tmp_path / "kept.npz")
    again = load_target(tmp_path / "kept.npz")
    assert again.digest == small.digest
    assert again.notes == small.notes != ()


def test_saving_is_whole_or_not_at_all(tmp_path, target, monkeypatch):
    with pytest.raises(InputError, match="cannot be written"):
        save_target(target, tmp_path / "no folder" / "kept.npz")
    with pytest.raises(InputError, match=r"ends in \.npz"):
        save_target(target, tmp_path / "kept.stl")

    def full_disk(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", full_disk)
    with pytest.raises(InputError, match="No space left"):
        save_target(target, tmp_path / "kept.npz")
    assert not list(tmp_path.iterdir())


def test_a_saved_outline_must_belong_to_its_heights(tmp_path, target):
    arrays = {"x_mm": target.x_mm, "y_mm": target.y_mm, "z_mm": target.z_mm}
    for outline in (target.outline_mm * 2, target.outline_mm[::-1], target.outline_mm[:, :1]):
        np.savez(tmp_path / "t.npz", outline_mm=outline, **arrays)
        with pytest.raises(InputError, match="outline_mm"):
            load_target(tmp_path / "t.npz")


def test_height_maps_are_read_scaled_and_coarsened(tmp_path, target):
    x, y, z = bumps()
    np.savez(tmp_path / "h.npz", x_mm=x.astype("f4"), y_mm=y.astype("f4"), z_mm=z.astype("f4"), source="me")
    assert_same_surface(load_target(tmp_path / "h.npz"), target, 1e-3)
    assert load_target(tmp_path / "h.npz", size_mm=(40, 60)).size_mm[0] == pytest.approx(40, rel=0.01)
    fine_x, fine_y = np.linspace(0, 20, 2101), np.linspace(0, 20, 1801)
    np.savez(tmp_path / "fine.npz", x_mm=fine_x, y_mm=fine_y, z_mm=np.hypot(*np.meshgrid(fine_x, fine_y)))
    fine = load_target(tmp_path / "fine.npz")
    assert fine.z_mm.shape == (600, 700)
    assert Surface(fine).height(np.array([0.0, 0.0])) == pytest.approx(np.hypot(10, 10), abs=0.05)


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({"x_mm": np.arange(9.0)}, ["no array y_mm", "no array z_mm"]),
        ({"x_mm": np.arange(9.0), "y_mm": np.arange(9.0), "z_mm": np.array(["a"] * 9)}, ["of type <U1"]),
        ({"x_mm": np.arange(9.0), "y_mm": np.arange(9.0), "z_mm": np.ones((9, 8))}, ["(9, 8)"]),
        ({"x_mm": np.arange(9.0), "y_mm": np.arange(9.0), "z_mm": np.ones((9, 9))}, ["constant"]),
        ({"x_mm": np.arange(9.0), "y_mm": np.arange(9.0), "z_mm": np.full((9, 9), np.nan)}, ["NaN everywhere"]),
        ({"x_mm": np.arange(9.0), "y_mm": np.array([None] * 9), "z_mm": np.ones((9, 9))}, ["cannot be read as .npz"]),
    ],
)
def test_wrong_height_maps_are_refused(tmp_path, arrays, words):
    np.savez(tmp_path / "wrong.npz", **arrays)
    with pytest.raises(InputError) as caught:
        load_target(tmp_path / "wrong.npz")
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".ply", ".glb", ".off", ".npz", ".png", ".tif", ".xyz"])
def test_missing_empty_and_scrambled_files_are_refused(tmp_path, suffix):
    options = {"size_mm": (40.0, 60.0), "depth_mm": 5.0} if suffix in (".png", ".tif") else {}
    path = tmp_path / f"file{suffix}"
    with pytest.raises(InputError, match="there is no file"):
        load_target(path, **options)
    path.write_bytes(b"")
    with pytest.raises(InputError, match="empty"):
        load_target(path, **options)
    path.write_bytes(bytes(range(256)) * 3)
    with pytest.raises(InputError, match=r"cannot be read|holds no|three numbers"):
        load_target(path, **options)


def test_options_and_suffixes_are_checked(tmp_path, target):
    (tmp_path / "face.step").write_text("solid")
    with pytest.raises(InputError, match=r"allowed are \.stl"):
        load_target(tmp_path / "face.step")
    with pytest.raises(InputError, match="is a folder"):
        load_target(tmp_path)
    save_target(target, tmp_path / "t.npz")
    with pytest.raises(InputError) as caught:
        load_target(tmp_path / "t.npz", up="+y", depth_mm=3.0)
    assert len(caught.value.problems) == 2
    path = write_mesh(tmp_path / "face.stl", *sheet(target))
    with pytest.raises(InputError, match="not a direction"):
        load_target(path, up="z")


def test_vertices_that_are_no_numbers_are_counted(tmp_path, target):
    vertices, triangles = sheet(target)
    vertices[7] = np.nan
    with pytest.raises(InputError, match=r"vertices .* are NaN") as caught:
        load_target(write_mesh(tmp_path / "nan.ply", vertices, triangles))
    assert f"1 of {len(vertices)}" in str(caught.value)
    assert "vertex 7" in str(caught.value)


def test_a_fin_on_the_surface_is_not_a_surface(tmp_path, target):
    vertices, triangles = sheet(target)
    tip = vertices[triangles[100]].mean(axis=0) + np.array([0, 0, 2.0])
    fin = np.array([[triangles[100, 0], triangles[100, 1], len(vertices)]])
    path = write_mesh(tmp_path / "fin.ply", np.vstack((vertices, tip)), np.vstack((triangles, fin)))
    with pytest.raises(InputError, match=r"at 1 edges of its top more than two triangles meet, the first at \("):
        load_target(path)


def test_doubled_triangles_and_hidden_fins_only_leave_notes(tmp_path):
    ball = trimesh.creation.icosphere(3, radius=10)
    low = int(np.argmin(ball.vertices[:, 2]))
    face = ball.faces[np.flatnonzero((ball.faces == low).any(axis=1))[0]]
    vertices = np.vstack((ball.vertices, [0, 0, -5.0]))
    fin = np.array([[face[0], face[1], len(ball.vertices)]])
    path = write_mesh(tmp_path / "ball.ply", vertices, np.vstack((ball.faces, fin, ball.faces[:2])))
    notes = load_target(path).notes
    assert "2 triangles that occurred twice were dropped." in notes
    assert any("below the top surface more than two" in note for note in notes)


def test_a_folded_sheet_is_refused_and_a_small_overhang_noted(tmp_path):
    def curled(reach):
        """Sheet along x whose far end rolls back over itself by `reach` mm."""
        arc = np.linspace(0, np.pi, 20)
        profile = np.vstack(
            (
                np.column_stack((np.linspace(-10, 10, 60), np.zeros(60))),
                np.column_stack((10 + 2 * np.sin(arc), 2 - 2 * np.cos(arc)))[1:],
                np.column_stack((np.linspace(10, 10 - reach, 10), np.full(10, 4.0)))[1:],
            )
        )
        rows = [
            np.column_stack((profile[:, 0], np.full(len(profile), y), profile[:, 1])) for y in np.linspace(0, 20, 30)
        ]
        index = np.arange(30 * len(profile)).reshape(30, -1)
        a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
        return np.vstack(rows), np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])

    path = write_mesh(tmp_path / "fold.stl", *curled(8.0))
    with pytest.raises(InputError, match=r"open sheet, overlaps itself along z: 4\d% of its top surface"):
        load_target(path)
    path = write_mesh(tmp_path / "curl.stl", *curled(-0.5))
    assert any("overhangs" in note for note in load_target(path).notes)


def test_edge_on_and_flat_meshes_are_refused(tmp_path, target):
    path = write_mesh(tmp_path / "wall.ply", [[0, 0, 0], [30, 0, 0], [0, 0, 30]], [[0, 1, 2]])
    with pytest.raises(InputError, match="a line or a point"):
        load_target(path)
    path = write_mesh(tmp_path / "flat.ply", [[0, 0, 0], [30, 0, 0], [0, 30, 0]], [[0, 1, 2]])
    with pytest.raises(InputError, match="constant"):
        load_target(path)
    path = write_mesh(tmp_path / "point.ply", np.zeros((3, 3)), [[0, 1, 2]])
    with pytest.raises(InputError, match="has an area"):
        load_target(path)


def test_two_bodies_side_by_side_are_two_pieces(tmp_path):
    balls = [trimesh.creation.icosphere(3, radius=5) for _ in range(2)]
    balls[1].apply_translation([12, 0, 0])
    trimesh.util.concatenate(balls).export(tmp_path / "two.stl")
    with pytest.raises(InputError, match="2 separate pieces"):
        load_target(tmp_path / "two.stl")


def test_solids_that_hide_each_other_are_refused(tmp_path):
    plates = [trimesh.creation.box((20, 20 - 10 * k, 1)) for k in range(2)]
    plates[1].apply_translation([0, 0, 5])
    trimesh.util.concatenate(plates).export(tmp_path / "plates.stl")
    with pytest.raises(InputError, match="closed solid, overlaps itself along z: 5"):
        load_target(tmp_path / "plates.stl")


@pytest.mark.parametrize(("suffix", "kind"), [(".png", np.uint8), (".png", np.uint16), (".tif", np.uint16)])
def test_images_are_upright_and_unstepped(tmp_path, target, suffix, kind):
    top = np.iinfo(kind).max
    grey = np.nan_to_num(1 + target.z_mm / target.depth_mm * (top - 1)).round().astype(kind)
    iio.imwrite(tmp_path / f"depth{suffix}", grey[::-1])
    found = load_target(tmp_path / f"depth{suffix}", size_mm=(20.0, 30.0), depth_mm=target.depth_mm)
    assert found.depth_mm == pytest.approx(target.depth_mm)
    assert max(found.size_mm[0] / 20, found.size_mm[1] / 30) == pytest.approx(1.0)
    assert_same_surface(found, target, 0.06)


def test_wrong_images_are_refused(tmp_path):
    path = tmp_path / "i.png"
    options = {"size_mm": (20.0, 30.0), "depth_mm": 5.0}
    iio.imwrite(path, np.full((40, 30), 7, np.uint8))
    with pytest.raises(InputError) as caught:
        load_target(path)
    assert len(caught.value.problems) == 2
    with pytest.raises(InputError, match="constant"):
        load_target(path, **options)
    iio.imwrite(path, np.zeros((40, 30), np.uint8))
    with pytest.raises(InputError, match="must be brighter"):
        load_target(path, **options)
    iio.imwrite(path, np.random.default_rng(0).integers(1, 255, (40, 30, 3), dtype=np.uint8))
    with pytest.raises(InputError, match="colour image"):
        load_target(path, **options)
    iio.imwrite(tmp_path / "f.tif", np.ones((40, 30), np.float32))
    with pytest.raises(InputError, match="type float32"):
        load_target(tmp_path / "f.tif", **options)


def scan(target, count=12000, seed=2):
    rng = np.random.default_rng(seed)
    xy = rng.uniform([-10, -15], [10, 15], (2 * count, 2))
    xy = xy[rng.random(2 * count) < np.where(xy[:, 0] > 0, 1.0, 0.3)]
    z = Surface(target).height(xy)
    points = np.column_stack((xy, z))[np.isfinite(z)]
    points += rng.normal(0.0, 0.05, points.shape)
    return np.vstack((points, rng.uniform([-30, -30, -30], [30, 30, 30], (12, 3)), points[:5]))


def test_scanned_clouds_are_fitted_through_noise_and_outliers(tmp_path, target):
    points = scan(target)
    np.savetxt(tmp_path / "scan.xyz", points, header="x y z")
    found = load_target(tmp_path / "scan.xyz")
    assert_same_surface(found, target, 0.15)
    assert found.size_mm == pytest.approx(target.size_mm, abs=0.6)
    assert any("far from all others" in note for note in found.notes)
    trimesh.PointCloud(points).export(tmp_path / "scan.ply")
    again = load_target(tmp_path / "scan.ply")
    assert_same_surface(again, found, 0.01)
    turned = load_target(tmp_path / "scan.ply", size_mm=(10, 15))
    assert max(turned.size_mm[0] / 10, turned.size_mm[1] / 15) == pytest.approx(1.0)


def test_wrong_clouds_are_refused(tmp_path, target):
    path = tmp_path / "scan.xyz"
    points = scan(target)
    np.savetxt(path, points[:50])
    with pytest.raises(InputError, match="at least 200 are needed"):
        load_target(path)
    path.write_text("0 0 1\n1 2\n")
    with pytest.raises(InputError, match=r"line 2 .* is '1 2'"):
        load_target(path)
    ball = np.random.default_rng(1).normal(size=(4000, 3))
    np.savetxt(path, 10 * ball / np.linalg.norm(ball, axis=1, keepdims=True))
    with pytest.raises(InputError, match="do not form one sheet"):
        load_target(path)
    points[::7] = np.nan
    np.savetxt(path, points)
    assert "NaN or infinite were dropped" in load_target(path).notes[0]


@pytest.mark.shared
def test_all_shared_surfaces_load_without_a_note(shared_dir):
    paths = sorted((shared_dir / "targets").glob("*.npz"))
    assert len(paths) == 10
    for path in paths:
        target = load_target(path)
        assert target.notes == ()
        with np.load(path) as arrays:
            assert target.depth_mm == pytest.approx(float(np.nanmax(arrays["z_mm"])), abs=1e-5)
            assert target.size_mm == pytest.approx(tuple(arrays["size_mm"]), abs=0.25)


@pytest.mark.shared
@pytest.mark.parametrize("name", ["ict_mean", "lps", "owl", "st_helens"])
def test_meshes_and_height_maps_of_the_same_surface_agree(shared_dir, name):
    mesh, heights = (load_target(shared_dir / "targets" / f"{name}.{suffix}") for suffix in ("stl", "npz"))
    assert mesh.notes == ()
    assert mesh.size_mm == pytest.approx(heights.size_mm, abs=0.2)
    points = np.stack(np.meshgrid(np.linspace(-29, 29, 120), np.linspace(-29, 29, 120)), axis=-1)
    difference = Surface(mesh).height(points) - Surface(heights).height(points)
    difference = np.abs(difference - np.nanmedian(difference))
    # The mesh has half the resolution: single nodes on steep noses and eyelids differ.
    assert np.nanquantile(difference, [0.5, 0.95]) == pytest.approx([0.0, 0.0], abs=0.1)
