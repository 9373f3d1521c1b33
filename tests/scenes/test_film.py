"""The heating as a film: it starts flat and ends hot, in every format."""

import sys

import imageio.v2 as imageio
import numpy as np
import pytest

from planner.errors import InputError
from scenes.filming import film_into
from scenes.pictures import heating_frames
from scenes.pictures.heating_film import SIZE_PX


@pytest.fixture
def heated(tmp_path, monkeypatch):
    """A folder with the shapes of a sheet that bends from 25 to 150 C."""
    monkeypatch.setenv("LCE_RENDERER", "relief")
    x, y = np.meshgrid(np.linspace(-10, 10, 15), np.linspace(-12, 12, 15))
    flat = np.column_stack([x.ravel(), y.ravel()])
    corner = (15 * np.arange(14)[:, None] + np.arange(14)).ravel()
    triangles = np.concatenate([corner[:, None] + (0, 1, 16), corner[:, None] + (0, 16, 15)])
    bend = np.array([0.0, 0.001, 0.02, 0.03])
    shapes = np.stack([np.column_stack([flat, 4 - k * (flat**2).sum(axis=1)]) for k in bend])
    np.savez(
        tmp_path / "heating.npz", temperature_c=(25.0, 80.0, 110.0, 150.0), vertices_mm=shapes, triangles=triangles
    )
    return tmp_path


def test_pictures_begin_cold_and_end_hot_and_hold(heated):
    with np.load(heated / "heating.npz") as archive:
        arrays = dict(archive)
    frames = list(heating_frames(**arrays, count=10, title="sheet"))
    assert len(frames) == 10
    assert all(frame.shape == (SIZE_PX[1], SIZE_PX[0], 3) for frame in frames)
    assert len({frame.tobytes() for frame in frames}) == 9
    np.testing.assert_array_equal(frames[-1], frames[-2])
    empty = [int((frame[-36] == (228, 231, 236)).all(axis=1).sum()) for frame in frames]
    assert empty == sorted(empty, reverse=True)
    assert empty[0] > empty[-1] + 300


@pytest.mark.parametrize("name", ["heating.gif", "frames"])
def test_films_have_all_their_pictures(lce, heated, tmp_path, name):
    out = tmp_path / "made" / name
    ran = lce("film", heated, "--out", out, "--frames", 6)
    assert ran.code == 0, ran.err
    if name == "frames":
        assert [path.name for path in sorted(out.iterdir())] == [f"frame_{k:04d}.png" for k in range(1, 7)]
        first, last = (imageio.imread(out / f"frame_{k:04d}.png") for k in (1, 6))
    else:
        pictures = imageio.mimread(out)
        # a GIF may join pictures that are alike: the last are
        assert len(pictures) in (5, 6)
        first, last = pictures[0][..., :3], pictures[-1][..., :3]
    assert first.shape == last.shape == (SIZE_PX[1], SIZE_PX[0], 3)
    assert np.abs(first.astype(int) - last).mean() > 1.0


def test_a_strip_shows_shapes_side_by_side_from_cold_to_hot(heated, tmp_path):
    six, three = tmp_path / "made" / "six.png", tmp_path / "made" / "three.png"
    assert film_into(six, heated) == 6
    assert film_into(three, heated, frames=3) == 3
    assert imageio.imread(six).shape[1] > 1.8 * imageio.imread(three).shape[1]
    image = imageio.imread(three).astype(int)
    sheets = image[image.shape[0] // 4 : image.shape[0] // 2]
    third = image.shape[1] // 3
    assert np.abs(sheets[:, :third] - sheets[:, 2 * third : 3 * third]).mean() > 1.0
    with pytest.raises(InputError, match="allowed are 2 to 60 in a strip"):
        film_into(tmp_path / "x.png", heated, frames=61)


def test_an_mp4_has_all_its_pictures(lce, heated, tmp_path):
    ffmpeg = pytest.importorskip("imageio_ffmpeg", reason="the extra 'film' is not installed")
    ran = lce("film", heated, "--out", tmp_path / "heating.mp4", "--frames", 50)
    assert ran.code == 0, ran.err
    count, seconds = ffmpeg.count_frames_and_secs(str(tmp_path / "heating.mp4"))
    assert count == 50
    assert seconds == pytest.approx(2.0, abs=0.05)


def test_wrong_films_are_refused(lce, heated, tmp_path, monkeypatch):
    lce("film", heated, "--out", tmp_path / "x.avi").assert_refused("allowed is a file that ends in .mp4, .gif or .png")
    lce("film", tmp_path / "absent", "--out", tmp_path / "x.gif").assert_refused("holds no heating.npz")
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.setattr("scenes.filming.find_spec", lambda name: None)
    lce("film", heated, "--out", tmp_path / "x.mp4").assert_refused("needs the package imageio-ffmpeg")
    (heated / "heating.npz").write_bytes(b"scrambled")
    lce("film", heated, "--out", tmp_path / "x.gif").assert_refused("cannot be read")
    assert not list(tmp_path.glob("x.*"))
