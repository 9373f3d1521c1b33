import numpy as np
import pytest

from planner.errors import InputError
from planner.target import save_target
from scenes.case import load_case
from scenes.sources import open_source, parse_size


@pytest.mark.parametrize(
    ("text", "size"),
    [("40x60", (40, 60)), ("40 X 60", (40, 60)), ("40.5*60.25mm", (40.5, 60.25)), (" 4x6 mm ", (4, 6)), (None, None)],
)
def test_sizes_are_read_as_people_write_them(text, size):
    assert parse_size(text) == size


@pytest.mark.parametrize("text", ["", "40", "x60", "40x", "40x60x80", "-40x60", "0x60", "4e1x60", "nanx60", "1.2.3x4"])
def test_what_is_no_size_is_refused(text):
    with pytest.raises(InputError, match=r"--size-mm: found .* write for example 40x60"):
        parse_size(text)


def test_a_name_and_a_case_file_are_the_same_case(dome_case, tmp_path):
    target, case = open_source("sphere_cap")
    assert case == load_case("sphere_cap")
    assert target.name == "sphere_cap"
    target, case = open_source(str(dome_case))
    assert case is not None
    assert target.name == case.name == "small dome"


def test_a_surface_file_is_no_case_and_takes_the_options(dome_case, tmp_path):
    whole = load_case(dome_case).make_target()
    save_target(whole, tmp_path / "dome.npz")
    target, case = open_source(str(tmp_path / "dome.npz"), size_mm="7x30")
    assert case is None
    assert target.size_mm == pytest.approx((7, 7 * whole.size_mm[1] / whole.size_mm[0]), rel=1e-6)
    assert target.depth_mm == pytest.approx(whole.depth_mm * 7 / whole.size_mm[0])
    assert open_source(str(tmp_path / "dome.npz"))[0].digest == whole.digest


def test_the_up_axis_reaches_the_reader(tmp_path):
    x, y = np.meshgrid(np.linspace(-10, 10, 61), np.linspace(-15, 15, 91))
    points = np.column_stack([part.ravel() for part in (x, y, 4 - (x / 8) ** 2)])
    np.savetxt(tmp_path / "lying.xyz", points[:, [0, 2, 1]] * [1, 1, -1])
    target, _ = open_source(str(tmp_path / "lying.xyz"), up="+y")
    assert target.size_mm == pytest.approx((20, 30), abs=0.6)
    assert target.depth_mm == pytest.approx((10 / 8) ** 2, abs=0.1)


@pytest.mark.parametrize(
    ("text", "options", "words"),
    [
        ("face.step", {}, r"'\.step', allowed are \.stl"),
        ("", {}, "folder|no built-in case"),
        ("spere_cap", {}, r"did you mean sphere_cap\?"),
        ("sphere_cap", {"size_mm": "4x6"}, "--size-mm 4x6 is for surface files"),
        ("sphere_cap", {"up": "-z", "depth_mm": 3.0}, r"--depth-mm 3.0, --up -z is for surface files"),
        ("absent.npz", {"size_mm": "4by6"}, "--size-mm"),
    ],
)
def test_what_is_no_source_is_refused(text, options, words):
    with pytest.raises(InputError, match=words):
        open_source(text, **options)
