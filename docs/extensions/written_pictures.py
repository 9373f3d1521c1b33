"""The gallery's pictures: the PNG files that an example writes into its folder `out`."""

import shutil
import time
from pathlib import Path
from typing import Any

from sphinx_gallery.scrapers import figure_rst

WRITTEN = "out"

_shown_until_ns = 0


def begin(settings: dict[str, Any], example: str) -> None:
    """Leave out what earlier runs wrote."""
    global _shown_until_ns
    _shown_until_ns = time.time_ns()


def scrape(block: tuple[Any, ...], variables: dict[str, Any], settings: dict[str, Any]) -> str:
    """Return the reStructuredText of the pictures that the example's last block wrote."""
    global _shown_until_ns
    written = (Path(variables["src_file"]).parent / WRITTEN).rglob("[!.]*.png")
    new = sorted((path.stat().st_mtime_ns, path) for path in written if path.stat().st_mtime_ns > _shown_until_ns)
    copies = []
    for (changed_ns, path), copy in zip(new, variables["image_path_iterator"], strict=False):
        shutil.copyfile(path, copy)
        copies.append(copy)
        _shown_until_ns = changed_ns
    return figure_rst(copies, settings["src_dir"])
