"""Exports read back: the same lengths, polylines and heights as went in."""

import csv
import json
import re
from xml.etree import ElementTree

import ezdxf
import imageio.v3 as imageio
import numpy as np
import pytest
import pyvista
import trimesh

from planner.program import load_program
from scenes.exports.depth import write_depth_images

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def program(planned):
    return load_program(planned)


@pytest.fixture
def exported(lce, planned, tmp_path):
    ran = lce("export", planned, "--out", tmp_path / "out")
    assert ran.code == 0, ran.err
    assert "layer_1.dxf" in ran.out
    return tmp_path / "out"


def length(points):
    return float(np.linalg.norm(np.diff(np.asarray(points, dtype=float), axis=0), axis=1).sum())


def test_svg_paths_are_as_long_as_the_passes_and_in_true_mm(exported, program):
    for layer in program.layers:
        root = ElementTree.parse(exported / f"layer_{layer.index + 1}.svg").getroot()
        width, height = (float(root.get(name).removesuffix("mm")) for name in ("width", "height"))
        assert root.get("viewBox") == f"0 0 {root.get('width')[:-2]} {root.get('height')[:-2]}"
        assert width == pytest.approx(np.ptp(np.array(program.film.outline_mm)[:, 0]) + 4.0)
        drawn = root.findall(f"{SVG}g/{SVG}path")
        assert len(drawn) == len(layer.passes)
        for path, stroke in zip(drawn, layer.passes, strict=True):
            points = np.array(re.findall(r"(-?[\d.]+) (-?[\d.]+)", path.get("d")), dtype=float)
            assert length(points) == pytest.approx(stroke.length_mm, abs=1e-4)
            assert points.min() > 0
            assert points[:, 0].max() < width
            assert points[:, 1].max() < height
            # up on the film is up in the drawing
            np.testing.assert_allclose(np.diff(points, axis=0), np.diff(stroke.points_mm, axis=0) * (1, -1), atol=3e-6)
            assert path.get("class") == stroke.side


def test_dxf_is_in_mm_and_has_the_same_polylines(exported, program):
    for layer in program.layers:
        document = ezdxf.readfile(exported / f"layer_{layer.index + 1}.dxf")
        assert document.header["$INSUNITS"] == 4
        assert not document.audit().errors
        lines = list(document.modelspace().query("LWPOLYLINE"))
        passes = [line for line in lines if line.dxf.layer in ("CONVEX", "CONCAVE")]
        assert len(passes) == len(layer.passes)
        for line, stroke in zip(passes, layer.passes, strict=True):
            np.testing.assert_allclose([point[:2] for point in line.get_points()], stroke.points_mm, atol=1e-9)
            assert line.dxf.layer == stroke.side.upper()
        (cut,) = (line for line in lines if line.dxf.layer == "CUT")
        assert cut.closed
        np.testing.assert_allclose([point[:2] for point in cut.get_points()], program.cut.line_mm, atol=1e-9)


def parsed(text):
    """Polylines with the feeds of their segments, while the post is down."""
    place, down, lines, feeds = np.zeros(2), False, [], []
    for line in text.splitlines():
        words = dict(re.findall(r"([GXYZF])(-?[\d.]+)", line.partition(";")[0]))
        if "Z" in words:
            down = float(words["Z"]) == 0.0
            if down:
                lines.append([place.copy()])
                feeds.append([])
        if "X" in words:
            place = np.array([float(words["X"]), float(words["Y"])])
            if down:
                assert words["G"] == "1"
                lines[-1].append(place.copy())
                feeds[-1].append(float(words["F"]))
            else:
                assert words["G"] == "0"
    return lines, feeds


def test_gcode_reads_back_as_the_same_polylines_and_warns(exported, program):
    for layer in program.layers:
        text = (exported / f"layer_{layer.index + 1}.gcode").read_text()
        assert text.startswith("; preview: not for a machine without the rig's audit\n")
        lines, feeds = parsed(text)
        assert len(lines) == len(layer.passes)
        for line, feed, stroke in zip(lines, feeds, layer.passes, strict=True):
            np.testing.assert_allclose(line, stroke.points_mm, atol=5.1e-5)
            np.testing.assert_allclose(np.array(feed) / 60.0, stroke.speed_mm_s, atol=1e-5)


def test_pass_tables_hold_every_point(exported, program):
    with (exported / "passes.csv").open() as file:
        rows = list(csv.DictReader(file))
    points = [point for layer in program.layers for stroke in layer.passes for point in stroke.points_mm]
    np.testing.assert_array_equal([(float(row["x_mm"]), float(row["y_mm"])) for row in rows], points)
    with np.load(exported / "passes.npz") as archive:
        np.testing.assert_array_equal(archive["x_mm"], [x for x, _ in points])
        starts = archive["point"] == 1
        assert np.all(np.isnan(archive["speed_mm_s"]) == starts)
        assert np.all(archive["contraction"][~starts] > 0)
    assert [row["speed_mm_s"] == "" for row in rows] == starts.tolist()


def test_depth_images_keep_heights_to_one_grey_step(tmp_path):
    rng = np.random.default_rng(0)
    z = rng.uniform(-2.0, 7.0, size=(12, 9))
    z[3:5, 2] = np.nan
    scan = {"x_mm": np.linspace(0, 8, 9), "y_mm": np.linspace(-3, 8, 12), "z_mm": z, "target_z_mm": z[:, ::-1] + 1}
    write_depth_images(tmp_path, scan)
    scale = json.loads((tmp_path / "depth.json").read_text())
    for name, key in (("shape_depth.png", "z_mm"), ("target_depth.png", "target_z_mm")):
        grey = imageio.imread(tmp_path / name)
        assert grey.dtype == np.uint16
        height = np.where(grey == 0, np.nan, scale["lowest_mm"] + (grey.astype(float) - 1) * scale["mm_per_step"])
        np.testing.assert_allclose(height[::-1], scan[key], atol=scale["mm_per_step"])
    assert scale["mm_per_step"] < 2e-4
    assert scale["first_pixel_centre_mm"] == [0.0, 8.0]


def test_a_prediction_gives_meshes_images_and_tables(lce, planned, tmp_path):
    lce("predict", planned, "--mesh-mm", 1.5, "--out", tmp_path / "hot")
    ran = lce("export", tmp_path / "hot", "--out", tmp_path / "out")
    assert ran.code == 0, ran.err
    shape = trimesh.load(tmp_path / "hot" / "shape.ply", process=False)
    for name in ("shape.ply", "shape.stl"):
        again = trimesh.load(tmp_path / "out" / name, process=False)
        np.testing.assert_allclose(again.triangles, shape.triangles, atol=1e-5)
    again = pyvista.read(tmp_path / "out" / "shape.vtp")
    np.testing.assert_allclose(again.points, shape.vertices, atol=1e-12)
    np.testing.assert_array_equal(again.regular_faces, shape.faces)
    result = json.loads((tmp_path / "hot" / "result.json").read_text())
    with (tmp_path / "out" / "result.csv").open() as file:
        numbers = {row["name"]: float(row["value"]) for row in csv.DictReader(file)}
    assert numbers["ssim_eq4"] == result["ssim_eq4"]
    assert numbers["equilibrium.energy_mj"] == result["equilibrium"]["energy_mj"]
    assert {"depth.json", "shape_depth.png", "target_depth.png", "depth.csv", "depth.npz"} <= {
        path.name for path in (tmp_path / "out").iterdir()
    }
    assert not (tmp_path / "out" / "passes.csv").exists()


def test_what_cannot_be_exported_is_refused(lce, tmp_path):
    (tmp_path / "empty").mkdir()
    lce("export", tmp_path / "empty", "--out", tmp_path / "out").assert_refused("holds neither program.json")
    lce("export", tmp_path / "absent", "--out", tmp_path / "out").assert_refused("no such file")
    (tmp_path / "empty" / "result.json").write_text("{")
    lce("export", tmp_path / "empty", "--out", tmp_path / "out").assert_refused("result.json: cannot be read")
    assert not (tmp_path / "out").exists()
