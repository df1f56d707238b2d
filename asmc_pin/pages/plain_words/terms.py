"""What the paper's terms mean: docs/glossary.md, which the wheel carries, as a part of a page that travels alone."""

from __future__ import annotations

import re
from functools import cache

from asmc_pin.disk.resources import shipped
from asmc_pin.words.media import for_html

_ITEM = re.compile(r"^- (.+?)(?=^- |^#|\Z)", re.MULTILINE | re.DOTALL)
_LINK = re.compile(r"\[([^\]]+)\]\([^)]*\)")

ANCHORS = {
    "mbar": "M̄ (",
    "tde": "TDE, ",
    "tde-error": "TDE error N",
    "s": "e, tracking error",
    "gain": "Switching gain",
    "lemma1": "Lemma 1",
    "chatter": "Chatter",
    "ensemble": "Ensemble",
}
"""How the entries begin that a report links to, by the name in its links."""


@cache
def terms_html() -> str:
    """The whole glossary, its sections as headings and its entries with the identifiers of `term_link`."""
    text = (shipped("docs") / "glossary.md").read_text(encoding="utf-8")
    parts = []
    for section in re.split(r"^## ", text, flags=re.MULTILINE)[1:]:
        title, _, body = section.partition("\n")
        items = "".join(_item(match[1]) for match in _ITEM.finditer(body))
        parts.append(f"<h3>{for_html(title)}</h3><ul>{items}</ul>")
    return "".join(parts)


def term_link(anchor: str, text: str) -> str:
    """A link within the page from a term to its meaning; the text is plain.

    Raises:
        KeyError: There is no such anchor.
    """
    assert ANCHORS[anchor]
    return f'<a class="term" href="#term-{anchor}">{for_html(text)}</a>'


def _item(markdown: str) -> str:
    flat = _LINK.sub(r"\1", " ".join(markdown.split()))
    plain = flat.removeprefix("**")
    anchor = next((name for name, begin in ANCHORS.items() if plain.startswith(begin)), None)
    html = re.sub(r"\*\*(.+?)\*\*", r"<strong>\1</strong>", for_html(flat))
    html = re.sub(r"(?<!\*)\*([^*]+)\*", r"<em>\1</em>", re.sub(r"`([^`]+)`", r"<code>\1</code>", html))
    mark = "" if anchor is None else f' id="term-{anchor}"'
    return f"<li{mark}>{html}</li>"
