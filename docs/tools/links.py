"""Do the links of a built site lead somewhere within it? python -m docs.tools.links folder"""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

_LINKS = {"a": "href", "link": "href", "img": "src", "script": "src", "iframe": "src", "source": "src"}
_LOADS = {"link", "img", "script", "iframe", "source"}


class _Page(HTMLParser):
    """The links of a page, (tag, target), and the places in it that can be linked to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[tuple[str, str]] = []
        self.places: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        given = dict(attributes)
        self.places.update(name for name in (given.get("id"), given.get("name") if tag == "a" else None) if name)
        target = given.get(_LINKS.get(tag, ""))
        if target is not None:
            self.links.append((tag, target))


def problems(site: Path) -> list[str]:
    """A sentence for each link without an end, and for whatever a page would load from another host."""
    pages = {path.resolve(): _Page(path.read_text(encoding="utf-8")) for path in sorted(site.rglob("*.html"))}
    found = []
    for path, page in pages.items():
        for tag, target in page.links:
            wrong = _wrong(path, tag, target, pages, site.resolve())
            if wrong:
                found.append(f"{path.relative_to(site.resolve())}: {target}: {wrong}")
    return found


def _wrong(page: Path, tag: str, target: str, pages: dict[Path, _Page], site: Path) -> str | None:
    parts = urlsplit(target)
    if parts.scheme == "data" or parts.scheme == "mailto":
        return None
    if parts.scheme or parts.netloc:
        return "is loaded from another host" if tag in _LOADS else None
    file = (page.parent / unquote(parts.path)).resolve() if parts.path else page
    file = file / "index.html" if file.is_dir() else file
    if not file.is_relative_to(site):
        return "is outside of the site"
    if not file.exists():
        return "there is no such file"
    place = unquote(parts.fragment)
    if place and file in pages and place not in pages[file].places:
        return "there is no such place in the page"
    return None


def main() -> None:
    site = Path(sys.argv[1])
    found = problems(site)
    print("\n".join(found) or f"{len(list(site.rglob('*.html')))} pages: every link within {site} leads somewhere")
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
