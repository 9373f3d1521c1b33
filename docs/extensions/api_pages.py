"""How autodoc's pages read: types linked under the names that packages export, drawings and colons as written."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Any, get_type_hints

from docutils import nodes
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.nodes import make_refnode

BOUNDS = {
    "gt": "above {}",
    "ge": "{} or more",
    "lt": "below {}",
    "le": "up to {}",
    "min_length": "length {} or more",
    "max_length": "length up to {}",
}
SHORT = (bool, int, float, str, tuple, type(None))
PLAIN = ("attribute", "data", "property")

_kept: dict[str, list[str]] = {}
_bounds_of: dict[str, str] = {}


def _link(app: Sphinx, env: BuildEnvironment, wanted: pending_xref, shown: nodes.TextElement) -> nodes.Element | None:
    """Link `planner.target.target.Target`, or `Target` alone, as the `planner.target.Target` that is documented."""
    if wanted.get("refdomain") != "py":
        return None
    module, _, name = wanted["reftarget"].rpartition(".")
    found = []
    for full, entry in env.domains.python_domain.objects.items():
        package, _, exported = full.rpartition(".")
        if exported == name and entry.objtype in ("class", "exception") and (not module or module.startswith(package)):
            found.append((entry.docname, entry.node_id))
    if len(found) != 1:
        return None
    docname, node_id = found[0]
    return make_refnode(app.builder, wanted["refdoc"], docname, node_id, shown)


def _fields(app: Sphinx, what: str, name: str, made: Any, options: Any, signature: str, returned: str) -> Any:
    """Show a pydantic model by its fields alone: each with its bare type; bounds and defaults follow in words."""
    if what != "class" or not (isinstance(made, type) and issubclass(made, BaseModel)):
        return None
    own = type("Own", (), {"__annotations__": made.__annotations__, "__module__": made.__module__})
    made.__annotations__ = get_type_hints(own)
    told = {
        field: ", ".join(_bounds(info)) for field, info in made.model_fields.items() if field in made.__annotations__
    }
    _bounds_of[name] = "; ".join(f"``{field}`` {words}" for field, words in told.items() if words)
    return "", None


def _bounds(info: FieldInfo) -> Iterator[str]:
    for bound in info.metadata:
        for attribute, words in BOUNDS.items():
            if (value := getattr(bound, attribute, None)) is not None:
                yield words.format(value)
    if info.default_factory is None and not info.is_required():
        yield f"default {info.default!r}" if isinstance(info.default, SHORT) else "has a default"


def _draw(app: Sphinx, what: str, name: str, made: Any, options: Any, lines: list[str]) -> None:
    """Show what is indented after a paragraph as it is: it is a drawing, an equation or a table."""
    shown: list[str] = []
    for before, line in pairwise(["", *lines]):
        if line.startswith("  ") and not before.strip() and _ends_a_paragraph(shown):
            shown += ["::", ""]
        shown.append(line)
    lines[:] = shown


def _ends_a_paragraph(lines: list[str]) -> bool:
    last = next((line for line in reversed(lines) if line.strip()), " ")
    return not last.startswith((" ", "- ")) and not last.endswith("::")


def _keep(app: Sphinx, what: str, name: str, made: Any, options: Any, lines: list[str]) -> None:
    """Remember the words of an attribute, which has no sections, before napoleon reads them."""
    if what in PLAIN:
        _kept[name] = list(lines)


def _restore(app: Sphinx, what: str, name: str, made: Any, options: Any, lines: list[str]) -> None:
    """Put them back, since napoleon takes what stands before a colon for a type; add a model's bounds to its words."""
    if what in PLAIN:
        lines[:] = _kept.pop(name)
    elif bounds := _bounds_of.get(name):
        lines += ["", f"Allowed: {bounds}."]


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect them; napoleon has priority 500."""
    app.connect("missing-reference", _link)
    app.connect("autodoc-process-signature", _fields)
    app.connect("autodoc-process-docstring", _draw, priority=300)
    app.connect("autodoc-process-docstring", _keep, priority=400)
    app.connect("autodoc-process-docstring", _restore, priority=600)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
