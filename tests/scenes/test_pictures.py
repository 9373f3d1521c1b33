import logging

import numpy as np
import pytest
from PIL import Image

from planner.errors import InputError
from planner.program import Actuate, CreatedBy, Cut, Film, Inputs, Layer, Pass, Program
from planner.target import surface_mesh, target_from_heights
from scenes.pictures import (
    CurrentPicture,
    draw_depth_images,
    draw_design,
    draw_error_map,
    draw_hot_shape,
    draw_plan,
    draw_side_by_side,
    draw_target,
)
from scenes.pictures.graphics import VARIABLE, renderer
from scenes.whole_file import whole_file
from twin.score import score_surface


@pytest.fixture(autouse=True)
def relief(monkeypatch):
    """Pictures of these tests need no OpenGL, unless a test says so."""
    monkeypatch.setenv(VARIABLE, "relief")


@pytest.fixture(scope="module")
def target():
    x, y = np.arange(-10, 10.1, 0.25), np.arange(-14, 14.1, 0.25)
    X, Y = np.meshgrid(x, y)
    z = 6 * np.sqrt(np.maximum(1.2 - (X / 10) ** 2 - (Y / 14) ** 2, 0))
    return target_from_heights("egg", x, y, np.where((X / 10) ** 2 + (Y / 14) ** 2 <= 1, z, np.nan))


@pytest.fixture(scope="module")
def mesh(target):
    return surface_mesh(target, 0.7)


def pixels(path):
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB")).astype(float)


def assert_marks_are_upright(path):
    """A red spot at the upper left, a blue one at the lower right."""
    image = pixels(path)
    image = image[:, : int(0.8 * image.shape[1])]
    red = np.argwhere(image[..., 0] - image[..., 2] > 80).mean(axis=0)
    blue = np.argwhere(image[..., 2] - image[..., 0] > 80).mean(axis=0)
    assert red[0] < blue[0] - 100
    assert red[1] < blue[1] - 100


def test_shapes_side_by_side_share_one_scale(tmp_path, mesh):
    vertices, triangles = mesh
    shapes = [vertices, 0.5 * vertices, vertices, vertices, vertices]
    draw_side_by_side(tmp_path / "five.png", shapes, triangles, list("abcde"), title="Five")
    image = pixels(tmp_path / "five.png")
    rows, columns = image.shape[0] // 2, image.shape[1] // 4
    first, half, *_ = ((image[:rows, k * columns : (k + 1) * columns].min(axis=2) < 230).sum() for k in range(4))
    assert half == pytest.approx(first / 4, rel=0.15)
    assert (image[rows:, : image.shape[1] // 4] < 200).any()
    assert (image[rows + rows // 4 :, image.shape[1] // 3 :] > 250).all()


def test_target_shape_and_error_stand_side_by_side(tmp_path, target, mesh):
    vertices, triangles = mesh
    draw_design(tmp_path / "design.png", target, score_surface(vertices * [1, 1, 0.8], triangles, target))
    CurrentPicture(target).draw(tmp_path / "current.png", vertices, triangles, caption="coarse")
    for name, panels in (("design.png", 3), ("current.png", 2)):
        image = pixels(tmp_path / name)
        area = image[120:-80, : int((0.9 if panels == 3 else 1.0) * image.shape[1])].min(axis=2) < 235
        shares = [part.mean() for part in np.array_split(area, panels, axis=1)]
        assert min(shares) > 0.2
        assert max(shares) < 1.2 * min(shares)


def draw_marks(path, mesh):
    vertices, triangles = mesh
    up_left = np.exp(-((vertices[:, 0] + 4) ** 2 + (vertices[:, 1] - 6) ** 2) / 6)
    down_right = np.exp(-((vertices[:, 0] - 4) ** 2 + (vertices[:, 1] + 6) ** 2) / 6)
    draw_error_map(path, vertices, triangles, up_left - down_right, rms_mm=0.3, hausdorff_mm=1.0)


def test_the_relief_is_upright_and_not_mirrored(tmp_path, mesh):
    draw_marks(tmp_path / "error_map.png", mesh)
    assert_marks_are_upright(tmp_path / "error_map.png")


def test_the_opengl_picture_is_upright_and_not_mirrored(tmp_path, mesh, monkeypatch):
    monkeypatch.setenv(VARIABLE, "auto")
    if renderer() != "opengl":
        pytest.skip("no OpenGL works on this machine")
    draw_marks(tmp_path / "error_map.png", mesh)
    assert_marks_are_upright(tmp_path / "error_map.png")


def test_light_comes_from_the_upper_left(tmp_path, target, mesh):
    draw_target(tmp_path / "target.png", target)
    draw_hot_shape(tmp_path / "hot_shape.png", *mesh, caption="150 C")
    for name in ("target.png", "hot_shape.png"):
        grey = pixels(tmp_path / name).mean(axis=2)
        height, width = grey.shape
        upper_left = grey[int(0.36 * height) : int(0.42 * height), int(0.34 * width) : int(0.40 * width)].mean()
        lower_right = grey[int(0.62 * height) : int(0.68 * height), int(0.62 * width) : int(0.68 * width)].mean()
        assert lower_right < upper_left < 250


def test_depth_images_show_both_and_the_map(tmp_path, target, mesh):
    vertices, triangles = mesh
    scored = score_surface(vertices * [1, 1, 0.7], triangles, target)
    path = tmp_path / "depth_images.png"
    draw_depth_images(path, target, scored.target_depth_mm, scored.shape_depth_mm, scored.ssim_map, scored.score)
    image = pixels(path)
    assert image.shape[1] > image.shape[0] > 300
    assert image.std() > 30


def program(*, sides=("convex", "concave"), placeholder=True):
    from planner.calibration import load_calibration

    record = load_calibration().record.model_copy(update={"placeholder": placeholder})
    limits = record.limits

    def passes(side, x):
        points = tuple((x + 0.05 * i, -6.0 + i) for i in range(13))
        speeds = tuple(np.linspace(limits.speed_mm_s_min, limits.speed_mm_s_max, 12).tolist())
        return (
            Pass(points_mm=points, speed_mm_s=speeds, load_g=(limits.load_g_max,), side=side),
            Pass(points_mm=points[::-1], speed_mm_s=speeds, load_g=(4.0,) * 13, side=side),
        )

    below, above = (passes(side, x) for side, x in zip(sides, (-3.0, 3.0), strict=True))
    layers = [Layer.of(i, 0.2, below if i < 2 else above) for i in range(4)]
    return Program(
        name="test",
        seed=0,
        created_by=CreatedBy(name="test", version="0"),
        inputs=Inputs(method="perpendicular"),
        calibration=record,
        film=Film(outline_mm=((-10, -10), (10, -10), (10, 10), (-10, 10)), layer_thickness_mm=(0.2,) * 4),
        layers=tuple(layers),
        finish=(Cut(line_mm=((-8, -8), (8, -8), (8, 8), (-8, 8))), Actuate()),
    )


def red_at_the_bottom(path):
    image = pixels(path)[-110:]
    return int(np.sum((image[..., 0] > 120) & (image[..., 1] < 60) & (image[..., 2] < 90)))


def test_a_plan_says_that_its_calibration_is_a_placeholder(tmp_path):
    draw_plan(tmp_path / "placeholder.png", program())
    draw_plan(tmp_path / "measured.png", program(placeholder=False))
    assert red_at_the_bottom(tmp_path / "placeholder.png") > 200
    assert red_at_the_bottom(tmp_path / "measured.png") == 0


def test_layers_of_their_own_have_panels_of_their_own(tmp_path):
    """Two pairs side by side, four layers in two rows; the dashes of concave passes leave more white."""
    pairs = program(placeholder=False)
    convex, concave = pairs.layers[0].passes, pairs.layers[3].passes
    own = (convex, convex[:1], concave, concave[:1])
    layers = tuple(Layer.of(i, 0.2, passes) for i, passes in enumerate(own))
    four = Program(**{**{name: getattr(pairs, name) for name in type(pairs).model_fields}, "layers": layers})
    draw_plan(tmp_path / "pairs.png", pairs)
    draw_plan(tmp_path / "four.png", four)
    two, image = pixels(tmp_path / "pairs.png"), pixels(tmp_path / "four.png")
    assert image.shape[1] == two.shape[1]
    assert image.shape[0] > 1.6 * two.shape[0]
    height, width = image.shape[0] // 2, int(0.45 * image.shape[1])
    coloured = np.ptp(image, axis=2) > 60
    panels = [
        coloured[r * height : (r + 1) * height - 120, c * width : (c + 1) * width] for r in (0, 1) for c in (0, 1)
    ]
    above, beside, below, last = (int(panel.sum()) for panel in panels)
    assert min(above, beside) > 1.3 * max(below, last)
    assert min(below, last) > 100


def test_a_plan_without_any_pass_is_drawn_too(tmp_path):
    bare = program()
    polydomain = tuple(Layer.of(i, 0.2) for i in range(4))
    bare = Program(**{**{name: getattr(bare, name) for name in type(bare).model_fields}, "layers": polydomain})
    draw_plan(tmp_path / "plan.png", bare)
    assert pixels(tmp_path / "plan.png").std() > 1


def test_a_picture_is_whole_or_not_there(tmp_path):
    path = tmp_path / "picture.png"
    path.write_bytes(b"old")

    def fail_half_way():
        with whole_file(path) as scratch:
            scratch.write_bytes(b"half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail_half_way()
    assert path.read_bytes() == b"old"
    with whole_file(path) as scratch:
        scratch.write_bytes(b"new")
    assert path.read_bytes() == b"new"
    assert list(tmp_path.iterdir()) == [path]


def test_the_renderer_can_be_forced(monkeypatch):
    assert renderer() == "relief"
    monkeypatch.setenv(VARIABLE, "vulkan")
    with pytest.raises(InputError, match="vulkan"):
        renderer()


def test_without_a_graphics_library_the_relief_is_drawn(monkeypatch, caplog):
    from scenes.pictures import graphics

    monkeypatch.setenv(VARIABLE, "auto")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setattr(graphics.ctypes.util, "find_library", lambda name: None)
    monkeypatch.setattr(graphics.sys, "platform", "linux")
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    graphics._opengl_works.cache_clear()
    with caplog.at_level(logging.INFO):
        assert renderer() == "relief"
    assert "relief" in caplog.text
    graphics._opengl_works.cache_clear()
