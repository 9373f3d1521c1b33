"""The pictures of a report: read from its folder, kept inside the page."""

import base64
from dataclasses import dataclass
from pathlib import Path

CAPTIONS = {
    "target": "The target",
    "hot_shape": "The predicted hot shape",
    "error_map": "Distance of the hot shape from the target",
    "depth_images": "Depth images, same scale, and where they agree",
    "plan": "What is scratched into the layers: convex solid, concave dashed, coloured by bending radius",
    "temperatures": "The temperatures that the film was taken through, in their order, all in one scale",
    "shapes_by_seed": "The shapes that differently disturbed films take, the most frequent first, in one scale",
    "noise": "How the scores of films with errors of the process spread",
}
"""Pictures by their files' names without .png."""


@dataclass(frozen=True, kw_only=True)
class Still:
    """A picture with its words."""

    caption: str
    source: str
    """The picture itself, as a data URL."""


def read_stills(folder: Path) -> dict[str, Still]:
    """Read those pictures that lie in the folder, by their names."""
    paths = {name: folder / f"{name}.png" for name in CAPTIONS}
    return {name: Still(caption=CAPTIONS[name], source=_url(path)) for name, path in paths.items() if path.is_file()}


def _url(path: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")
