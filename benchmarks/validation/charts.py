"""Pictures of the page: lines over axes, and bent films seen from the front."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

FOLDER = "pictures"


def new_figure(width_in: float, height_in: float) -> Figure:
    figure = Figure(figsize=(width_in, height_in), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, docs: Path, name: str) -> None:
    folder = docs / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / name, metadata={"Software": None})


def draw_films(
    docs: Path, name: str, films: Sequence[tuple[str, np.ndarray, np.ndarray]], *, columns: int | None = None
) -> None:
    """Draw bent films side by side at one scale, laid level as they are: title, vertices [mm], triangles."""
    films = [(title, _level(vertices, triangles), triangles) for title, vertices, triangles in films]
    columns = columns or len(films)
    rows = -(-len(films) // columns)
    figure = new_figure(3.6 * columns, 3.4 * rows)
    reach = 0.5 * max(float(np.ptp(vertices, axis=0).max()) for _, vertices, _ in films)
    for number, (title, vertices, triangles) in enumerate(films, start=1):
        axes = figure.add_subplot(rows, columns, number, projection="3d")
        middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
        axes.plot_trisurf(*vertices.T, triangles=triangles, color="#e6d5bf", linewidth=0.0, antialiased=False)
        axes.set(
            xlim=middle[0] + np.array((-reach, reach)),
            ylim=middle[1] + np.array((-reach, reach)),
            zlim=middle[2] + np.array((-reach, reach)),
        )
        axes.set_title(title, fontsize=10)
        axes.set_box_aspect((1, 1, 1))
        axes.view_init(elev=28, azim=-60)
        axes.tick_params(labelsize=7)
    figure.supxlabel("x, y, z [mm]", fontsize=8)
    save(figure, docs, name)


def _level(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Turn a film until the mean of its normals points upwards, top face up."""
    corners = vertices[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).sum(axis=0)
    turn = Rotation.align_vectors([[0.0, 0.0, 1.0]], [normal / np.linalg.norm(normal)])[0]
    return turn.apply(vertices)
