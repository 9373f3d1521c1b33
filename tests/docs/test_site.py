"""The documentation: no link inside the built site leads nowhere, no page is forgotten, nothing is fetched."""

from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

PROJECT = Path(__file__).resolve().parents[2]
SITE = PROJECT / "out" / "docs"
LINKING = {"a": "href", "link": "href", "img": "src", "script": "src", "source": "src"}


class Page(HTMLParser):
    """What a page links to, and the anchors that it has."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors = {"", "top"}
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.anchors.update(value for name in ("id", "name") if (value := given.get(name)))
        if link := given.get(LINKING.get(tag, "")):
            self.links.append(link)


def broken_links(site: Path) -> list[str]:
    """Return a sentence for each link to a file or an anchor that is not there."""
    pages = {path.resolve(): Page(path) for path in site.rglob("*.html")}
    broken = []
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            to = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not to.is_file():
                broken.append(f"{path.relative_to(site.resolve())}: {link}: no such file")
            elif to in pages and unquote(parts.fragment) not in pages[to].anchors:
                broken.append(f"{path.relative_to(site.resolve())}: {link}: no such anchor")
    return sorted(set(broken))


@pytest.mark.site
def test_no_link_inside_the_site_is_broken():
    assert (SITE / "index.html").is_file(), "run `make docs`"
    assert broken_links(SITE) == []


@pytest.mark.site
def test_every_page_and_every_example_is_in_the_site():
    pages = {path.stem for path in PROJECT.glob("docs/*.md")} | {path.stem for path in PROJECT.glob("examples/*.py")}
    assert pages <= {path.stem for path in SITE.rglob("*.html")}


@pytest.mark.site
def test_nothing_in_the_site_is_fetched_from_elsewhere():
    fetched = ('src="http', 'src="//', 'rel="stylesheet" href="http', "@import url(http")
    for path in [*SITE.rglob("*.html"), *SITE.rglob("*.css")]:
        text = path.read_text(encoding="utf-8")
        assert not [mark for mark in fetched if mark in text], path


def test_broken_links_are_found(tmp_path):
    (tmp_path / "index.html").write_text(
        '<a href="other.html#here">1</a> <a href="other.html#gone">2</a> <a href="absent.html?v=1">3</a> '
        '<img src="absent.png"> <a href="https://example.org/gone">4</a> <a href="#top">5</a>',
        encoding="utf-8",
    )
    (tmp_path / "other.html").write_text('<h1 id="here">x</h1><a href="index.html">6</a>', encoding="utf-8")
    assert broken_links(tmp_path) == [
        "index.html: absent.html?v=1: no such file",
        "index.html: absent.png: no such file",
        "index.html: other.html#gone: no such anchor",
    ]
