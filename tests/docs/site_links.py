"""Find links inside a built site that lead nowhere; links to other sites are left alone."""

from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

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
