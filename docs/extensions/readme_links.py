"""The README is the site's first page: its links, relative to the project, are made relative to docs/."""

import re
from pathlib import Path

from sphinx.application import Sphinx

LINK = re.compile(r"\]\((?!https?://|#)(?P<to>[^)\s]+)\)")


def relative_to_docs(markdown: str) -> str:
    """Return Markdown of the project's folder as it must read in docs/."""
    return LINK.sub(lambda link: f"]({_seen_from_docs(link['to'])})", markdown)


def _seen_from_docs(to: str) -> str:
    if to == "examples":  # a folder in the project, a gallery in the site
        return "gallery/index.rst"
    return to.removeprefix("docs/") if to.startswith("docs/") else f"../{to}"


def _read(app: Sphinx, relative: Path, parent: str, content: list[str]) -> None:
    if relative.name in ("README.md", "CHANGELOG.md"):
        content[0] = relative_to_docs(content[0])


def setup(app: Sphinx) -> dict[str, bool]:
    """Rewrite links when an include is read."""
    app.connect("include-read", _read)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
