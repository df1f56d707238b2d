"""What a built page would load from another host. Nothing, or the site needs a network, and tells others who reads."""

from __future__ import annotations

import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

_AWAY = re.compile(r"\s*(?:https?:)?//")

_LOADING = {"src", "srcset", "data", "poster", "background", "xlink:href"}
"""Attributes that load, of whatever element."""

_LOADING_BY_HREF = {"link", "image", "use", "feimage"}
"""Elements whose `href` loads; elsewhere it is a link that a reader may follow."""

_ONLY_NAMED = {"canonical", "alternate", "author", "license", "help", "next", "prev", "search", "index"}
"""Relations of a `link` that say where something is, and load nothing."""

_IN_STYLE = re.compile(r"(?:@import\s+|url\(\s*)[\"']?(\s*(?:https?:)?//[^\"')\s;]+)")
_IN_SCRIPT = re.compile(
    r"(?:\bimport\b[\w\s{},*$]*\(?|\bfrom|\bfetch\(|\bimportScripts\(|\bsrc\s*=)\s*[\"'`](\s*(?:https?:)?//[^\"'`\s]+)"
)


class _Page(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []
        self.inside = ""

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.inside = tag if tag in ("script", "style") else self.inside
        given = {name: value or "" for name, value in attributes}
        named = tag == "link" and set(given.get("rel", "").lower().split()) <= _ONLY_NAMED
        for name, value in given.items():
            if name == "srcdoc":
                self.found += in_page(value)
            elif name == "style":
                self.found += _IN_STYLE.findall(value)
            elif name in _LOADING or (name == "href" and tag in _LOADING_BY_HREF and not named):
                each = value.split(",") if name == "srcset" else [value]
                self.found += [address.strip() for address in each if _AWAY.match(address)]

    def handle_endtag(self, tag: str) -> None:
        self.inside = "" if tag == self.inside else self.inside

    def handle_data(self, data: str) -> None:
        if self.inside:
            self.found += (_IN_STYLE if self.inside == "style" else _IN_SCRIPT).findall(data)


def in_page(html: str) -> list[str]:
    """Addresses of other hosts from which a page loads, pages within it included; links to follow do not count."""
    page = _Page()
    page.feed(html)
    page.close()
    return page.found


def in_site(folder: Path) -> Iterator[tuple[Path, str]]:
    """Each file of a built site that loads from another host, with the address."""
    for path in sorted(folder.rglob("*")):
        look = {".html": in_page, ".svg": in_page, ".css": _IN_STYLE.findall, ".js": _IN_SCRIPT.findall}.get(
            path.suffix
        )
        if look is not None:
            for address in look(path.read_text(encoding="utf-8")):
                yield path, address
