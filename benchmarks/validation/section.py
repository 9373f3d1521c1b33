"""What a part of the validation finds: checks with verdicts, tables, words and pictures."""

from collections.abc import Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True, kw_only=True)
class Check:
    """One line of the summary."""

    name: str
    expected: str
    found: str
    error: str
    passed: bool | None
    """None where nothing is promised and the finding is only reported."""

    @property
    def verdict(self) -> str:
        return {True: "ok", False: "**fails**", None: "reported"}[self.passed]


@dataclass(frozen=True, kw_only=True)
class Section:
    """A part of the page."""

    title: str
    checks: tuple[Check, ...]
    blocks: tuple[str, ...] = field(default=())
    """Markdown: paragraphs, tables, pictures."""


def relative(name: str, expected: float, found: float, *, limit: float, unit: str = "", digits: int = 4) -> Check:
    """Check a number by its relative error."""
    error = found / expected - 1.0
    tail = f" {unit}" if unit else ""
    return Check(
        name=name,
        expected=f"{expected:.{digits}g}{tail} within {limit:.1%}",
        found=f"{found:.{digits}g}{tail}",
        error=f"{error:+.2%}",
        passed=abs(error) <= limit,
    )


def table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Return a Markdown table."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def picture(name: str, words: str) -> str:
    """Return the Markdown of a picture beside the page."""
    return f"![{words}](pictures/{name})"
