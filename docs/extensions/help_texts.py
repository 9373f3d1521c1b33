"""A directive that shows the help of every command, as the tests hold it."""

from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

HELP = Path(__file__).resolve().parents[2] / "tests" / "scenes" / "help"
"""One text for each command, compared with the real one by tests/scenes/test_cli_help.py."""


class HelpTexts(SphinxDirective):
    """Insert a section for `lce` itself and one for each command."""

    def run(self) -> list[nodes.Node]:
        """Return the sections."""
        files = sorted(HELP.glob("*.txt"), key=lambda path: (path.stem != "lce", path.stem))
        return [self._section(path) for path in files]

    def _section(self, path: Path) -> nodes.section:
        self.env.note_dependency(str(path))
        title = "lce" if path.stem == "lce" else f"lce {path.stem}"
        section = nodes.section(ids=[title.replace(" ", "-")], names=[title])
        section += nodes.title(title, "", nodes.literal(title, title))
        text = path.read_text(encoding="utf-8").strip("\n")
        section += nodes.literal_block(text, text, language="text", classes=["help"])
        return section


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("help-texts", HelpTexts)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
