"""The documentation: no link inside the built site leads nowhere, and no page is forgotten."""

import runpy
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
SITE = PROJECT / "out" / "docs"
broken_links = runpy.run_path(str(Path(__file__).with_name("site_links.py")))["broken_links"]


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
