"""A surface in 3-D, seen as one looks at a face: from the front, a little from the side and below."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from scenes.pictures.graphics import renderer
from scenes.whole_file import whole_file

if TYPE_CHECKING:
    import pyvista

SIZE_PX = (1000, 1200)
VIEW_FROM = np.array([0.32, -0.26, 1.0])
"""Direction from the surface to the viewer; +y stays up, and the viewer is far away (no perspective)."""
_LIGHT_FROM = np.array([-0.66, 0.62, 0.42])
"""Direction to the main light in the viewer's frame (right, up, towards the viewer): the upper left, raking, since
hot films are shallow."""
SKIN = "#e6d5bf"


@dataclass(frozen=True, kw_only=True, eq=False)
class Colours:
    """A number at each vertex, shown as colour."""

    values: np.ndarray
    """One value for each vertex, shape [n], float."""
    label: str
    """What they are, with the unit."""
    low: float
    high: float
    colour_map: str


def draw_relief(
    path: str | Path,
    vertices_mm: np.ndarray,
    triangles: np.ndarray,
    *,
    title: str,
    caption: str = "",
    colours: Colours | None = None,
) -> None:
    """Draw a surface, lit from the upper left, into a PNG.

    Args:
        path: File to write, whole or not at all.
        vertices_mm: Vertices [mm], z towards the viewer, y up, shape [n, 3], float.
        triangles: Vertex indices, shape [m, 3], int.
        title: Written above the surface.
        caption: Written below it, under its size.
        colours: Shown instead of one plain colour.
    """
    extent = np.ptp(vertices_mm[np.unique(triangles)], axis=0)
    lines = f"{extent[0]:.1f} x {extent[1]:.1f} mm, {extent[2]:.1f} mm deep" + (f"\n{caption}" if caption else "")
    image = relief_image(vertices_mm, triangles, half_height(vertices_mm), colours=colours)
    _write(path, image, title, lines, colours)


def relief_image(
    vertices_mm: np.ndarray,
    triangles: np.ndarray,
    half_height_mm: float,
    *,
    colours: Colours | None = None,
    size_px: tuple[int, int] = SIZE_PX,
) -> np.ndarray:
    """Return the bare picture of a surface, shape [h, w, 3], uint8.

    Args:
        vertices_mm: Vertices [mm], z towards the viewer, y up, shape [n, 3], float.
        triangles: Vertex indices, shape [m, 3], int.
        half_height_mm: Half the height of the picture [mm], as of `half_height`: the scale.
        colours: Shown instead of one plain colour.
        size_px: Width and height [px].
    """
    draw = _opengl_image if renderer() == "opengl" else _relief_image
    return draw(vertices_mm, triangles, half_height_mm, colours, size_px)


def half_height(vertices_mm: np.ndarray, *, aspect: float = SIZE_PX[0] / SIZE_PX[1]) -> float:
    """Return half the height of a picture that the surface fits into with a margin [mm].

    Args:
        vertices_mm: Vertices [mm], shape [n, 3], float.
        aspect: Width of the picture over its height.
    """
    seen = vertices_mm @ _view().T
    width, height = np.ptp(seen[:, 0]), np.ptp(seen[:, 1])
    return 0.54 * float(max(height, width / aspect))


def light_from() -> np.ndarray:
    """Return the direction to the main light in the surface's frame, shape [3]."""
    return _LIGHT_FROM @ _view()


def _view() -> np.ndarray:
    """Rows: the viewer's right, up and towards-the-viewer directions, shape [3, 3]."""
    towards = VIEW_FROM / np.linalg.norm(VIEW_FROM)
    right = np.cross([0.0, 1.0, 0.0], towards)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(towards, right), towards])


def stage_relief(
    plotter: "pyvista.Plotter",
    vertices_mm: np.ndarray,
    triangles: np.ndarray,
    half_height_mm: float,
    *,
    colours: Colours | None = None,
) -> None:
    """Put a surface, its light and the camera into a plotter's present place, as all relief pictures have them.

    Args:
        plotter: pyvista's, made without lighting of its own.
        vertices_mm: Vertices [mm], z towards the viewer, y up, shape [n, 3], float.
        triangles: Vertex indices, shape [m, 3], int.
        half_height_mm: Half the height of the picture [mm], as of `half_height`: the scale.
        colours: Shown instead of one plain colour.
    """
    import pyvista

    mesh = pyvista.PolyData.from_regular_faces(vertices_mm, triangles)
    plotter.background_color = pyvista.Color("white")
    shared = {"smooth_shading": True, "specular": 0.04, "ambient": 0.10, "show_scalar_bar": False}
    if colours is None:
        plotter.add_mesh(mesh, color=SKIN, **shared)
    else:
        plotter.add_mesh(
            mesh, scalars=colours.values, cmap=colours.colour_map, clim=(colours.low, colours.high), **shared
        )
    right, up, towards = view = _view()
    seen = vertices_mm @ view.T
    middle = 0.5 * (seen.min(axis=0) + seen.max(axis=0)) @ view
    for direction, intensity in ((_LIGHT_FROM, 0.92), (np.array([0.5, 0.0, 1.0]), 0.16)):
        world = direction @ np.stack([right, up, towards])
        light = pyvista.Light(position=tuple(middle + 1e3 * world), focal_point=tuple(middle))
        light.positional, light.intensity = False, intensity
        plotter.add_light(light, only_active=True)
    plotter.camera.parallel_projection = True
    plotter.camera_position = [tuple(middle + 200.0 * towards), tuple(middle), tuple(up)]
    plotter.camera.parallel_scale = half_height_mm


def _opengl_image(
    vertices: np.ndarray, triangles: np.ndarray, half: float, colours: Colours | None, size_px: tuple[int, int]
) -> np.ndarray:
    """Draw with pyvista, off screen, shape [h, w, 3]."""
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=list(size_px), lighting="none")
    try:
        stage_relief(plotter, vertices, triangles, half, colours=colours)
        plotter.enable_anti_aliasing("ssaa")
        return np.asarray(plotter.screenshot(None, return_img=True))
    finally:
        plotter.close()


def _relief_image(
    vertices: np.ndarray, triangles: np.ndarray, half: float, colours: Colours | None, size_px: tuple[int, int]
) -> np.ndarray:
    """Draw by a z-buffer of the turned surface and the shade of its slopes, shape [h, w, 3]."""
    import matplotlib
    from matplotlib.colors import Normalize, to_rgb
    from scipy.spatial import KDTree

    from twin.scan import depth_image, pixel_centres

    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2.0
    seen = (vertices - middle) @ _view().T
    reach = half * np.array([size_px[0] / size_px[1], 1.0])
    centre = (seen[:, :2].min(axis=0) + seen[:, :2].max(axis=0)) / 2.0
    bounds = centre - reach, centre + reach
    depth = depth_image(seen, triangles, bounds, size_px)
    surface = np.isfinite(depth)

    # Smooth shading: the normals of the vertices, carried to the pixels by the three nearest vertices.
    a, b, c = (seen[triangles[:, i]] for i in range(3))
    facet = np.cross(b - a, c - a)
    facet *= np.sign(facet[:, 2:])
    normals = np.zeros_like(seen)
    for corner in range(3):
        np.add.at(normals, triangles[:, corner], facet)
    used = np.unique(triangles)
    xy = pixel_centres(bounds, size_px)[surface]
    distance, nearest = KDTree(seen[used]).query(np.column_stack([xy, depth[surface]]), k=3)
    weight = 1.0 / (np.asarray(distance) + 1e-6) ** 2
    weight /= weight.sum(axis=1, keepdims=True)
    corners = used[np.asarray(nearest)]
    normal = np.einsum("ij,ijk->ik", weight, normals[corners])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    light = _LIGHT_FROM / np.linalg.norm(_LIGHT_FROM)
    shade = 0.06 + 0.95 * np.clip(normal @ light, 0.0, 1.0) + 0.17 * normal[:, 2]
    if colours is None:
        base = np.array(to_rgb(SKIN))
    else:
        values = np.einsum("ij,ij->i", weight, colours.values[corners])
        base = matplotlib.colormaps[colours.colour_map](Normalize(colours.low, colours.high)(values))[:, :3]
    image = np.ones((size_px[1], size_px[0], 3))
    image[surface] = np.clip(base * shade[:, None], 0.0, 1.0)
    return (255 * image).astype(np.uint8)


def _write(path: str | Path, image: np.ndarray, title: str, lines: str, colours: Colours | None) -> None:
    """Frame an image with its words and its colour bar."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0 if colours is None else 8.2, 9.4), dpi=130, facecolor="white")
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.02, 0.08, 0.96 if colours is None else 0.82, 0.85))
    axes.imshow(image)
    axes.set_axis_off()
    figure.text(0.5, 0.955, title, ha="center", va="center", fontsize=15)
    figure.text(0.5, 0.045, lines, ha="center", va="center", fontsize=12)
    if colours is not None:
        mappable = ScalarMappable(Normalize(colours.low, colours.high), colours.colour_map)
        bar = figure.colorbar(mappable, cax=figure.add_axes((0.86, 0.20, 0.025, 0.60)))
        bar.set_label(colours.label, fontsize=12)
    with whole_file(path) as scratch:
        figure.savefig(scratch)
