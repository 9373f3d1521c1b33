"""Surfaces that no film can become: refused in one line each, and nothing is written."""

import imageio.v3 as iio
import numpy as np
import pytest
import trimesh


def grid(factor=1.0):
    """Heights of a gentle hill, 20 x 30 mm times the factor."""
    x, y = np.linspace(-10, 10, 41), np.linspace(-15, 15, 61)
    X, Y = np.meshgrid(x, y)
    return factor * x, factor * y, factor * (4 - (X / 8) ** 2 - (Y / 12) ** 2)


def hill(factor=1.0):
    """The same hill as an open mesh: vertices and triangles."""
    x, y, z = grid(factor)
    return sheet(*np.meshgrid(x, y), z)


def sheet(X, Y, Z):
    """Open mesh over a grid of points, two triangles a cell."""
    index = np.arange(Z.size).reshape(Z.shape)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    triangles = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return np.column_stack((X.ravel(), Y.ravel(), Z.ravel())), triangles


def write_mesh(path, vertices, triangles):
    trimesh.Trimesh(vertices, triangles, process=False).export(path)


def write_heights(path, change):
    x, y, z = grid()
    np.savez(path, x_mm=x, y_mm=y, z_mm=change(z, *np.meshgrid(x, y)))


def non_manifold(path):
    vertices, triangles = hill()
    tip = vertices[triangles[900]].mean(axis=0) + np.array([0, 0, 2.0])
    fin = [[triangles[900, 0], triangles[900, 1], len(vertices)]]
    write_mesh(path, np.vstack((vertices, tip)), np.vstack((triangles, fin)))


def folded(path):
    along, y = np.linspace(0, 40, 81), np.linspace(0, 20, 21)
    A, Y = np.meshgrid(along, y)
    write_mesh(path, *sheet(np.where(A < 20, A, 40 - A), Y, np.where(A < 20, 0.01 * A, 3 + 0.01 * A)))


def not_a_number(path):
    vertices, triangles = hill()
    vertices[77] = np.nan
    write_mesh(path, vertices, triangles)


def two_bodies(path):
    balls = [trimesh.creation.icosphere(3, radius=5) for _ in range(2)]
    balls[1].apply_translation([12, 0, 0])
    trimesh.util.concatenate(balls).export(path)


def seen_edge_on(path):
    write_mesh(path, [[0, 0, 0], [30, 0, 0], [0, 0, 30]], [[0, 1, 2]])


BAD = {
    "missing.stl": (lambda path: None, "there is no file"),
    "empty.stl": (lambda path: path.write_bytes(b""), "is empty"),
    "no_triangles.obj": (lambda path: path.write_text("# nothing\n"), "holds no"),
    "scrambled.ply": (lambda path: path.write_bytes(bytes(range(256))), "cannot be read"),
    "non_manifold.ply": (non_manifold, "more than two triangles meet"),
    "folded.stl": (folded, "overlaps itself along z"),
    "nan.ply": (not_a_number, "vertex 77"),
    "metres.stl": (lambda path: write_mesh(path, *hill(2000.0)), "--size-mm 40x60"),
    "microns.stl": (lambda path: write_mesh(path, *hill(0.002)), "--size-mm 40x60"),
    "edge_on.ply": (seen_edge_on, "a line or a point"),
    "two_bodies.stl": (two_bodies, "2 separate pieces"),
    "two_pieces.npz": (lambda path: write_heights(path, lambda z, X, Y: np.where(abs(X) < 3, np.nan, z)), "2 separate"),
    "hole.npz": (lambda path: write_heights(path, lambda z, X, Y: np.where(np.hypot(X, Y) < 4, np.nan, z)), "hole"),
    "constant.npz": (lambda path: write_heights(path, lambda z, X, Y: 0 * z + 5), "constant"),
    "all_nan.npz": (lambda path: write_heights(path, lambda z, X, Y: np.nan * z), "NaN everywhere"),
    "infinite.npz": (lambda path: write_heights(path, lambda z, X, Y: np.where(X == 0, np.inf, z)), "inf"),
    "tower.npz": (lambda path: write_heights(path, lambda z, X, Y: 100 * z), "up to 3 times the width"),
    "few.xyz": (lambda path: np.savetxt(path, hill()[0][:50]), "at least 200"),
    "surface.step": (lambda path: path.write_text("solid"), "allowed are .stl"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_surface_that_no_film_can_become_is_refused(lce, tmp_path, name):
    write, words = BAD[name]
    write(tmp_path / name)
    before = set(tmp_path.iterdir())
    lce("plan", tmp_path / name, "--out", tmp_path / "out").assert_refused(words)
    assert set(tmp_path.iterdir()) == before


def test_the_same_surface_in_good_order_is_taken(lce, tmp_path):
    write_mesh(tmp_path / "hill.stl", *hill())
    ran = lce("plan", tmp_path / "hill.stl", "--out", tmp_path / "out")
    assert (ran.code, ran.err) == (0, "")


@pytest.mark.parametrize(
    ("options", "problems"),
    [
        ((), ["depth", "size"]),
        (("--size-mm", "20x30"), ["depth"]),
        (("--size-mm", "20x30", "--depth-mm", "0"), ["depth"]),
        (("--size-mm", "20x30", "--depth-mm", "-2"), ["depth"]),
        (("--size-mm", "20x30", "--depth-mm", "nan"), ["depth"]),
        (("--size-mm", "20x30", "--depth-mm", "5000"), ["Must be <= 300"]),
        (("--size-mm", "20x30", "--depth-mm", "5", "--up", "+y"), ["up"]),
        (("--size-mm", "20", "--depth-mm", "5"), ["--size-mm: found '20'"]),
        (("--size-mm", "20x", "--depth-mm", "5"), ["write for example 40x60"]),
        (("--size-mm", "0x30", "--depth-mm", "5"), ["allowed is width x height"]),
        (("--size-mm", "1.2.3x30", "--depth-mm", "5"), ["allowed is width x height"]),
        (("--size-mm", "wide", "--depth-mm", "5"), ["found 'wide'"]),
        (("--size-mm", "4000x6000", "--depth-mm", "5"), ["each side must be"]),
        (("--size-mm", "20x30", "--depth-mm", "deep"), ['"deep"']),
    ],
)
def test_options_of_an_image_are_checked(lce, tmp_path, options, problems):
    z = grid()[2]
    iio.imwrite(tmp_path / "i.png", np.interp(z, (z.min(), z.max()), (1, 255)).astype(np.uint8))
    lce("plan", tmp_path / "i.png", "--out", tmp_path / "out", *options).assert_refused(*problems)
    assert [path.name for path in tmp_path.iterdir()] == ["i.png"]
