"""Text on its way into a page, a paper, a figure or an encoding: one function for each.

Each of `for_html`, `for_markdown`, `for_cell`, `for_latex` and `for_figure` is applied once, to a whole text, where it
is put into that medium; what is handed around before is plain.
"""

from __future__ import annotations

import re
import unicodedata
from html import escape

from asmc_pin.words.text import as_escape, printable, visible


def for_html(text: str) -> str:
    """Text as an element or an attribute of HTML shows it; line breaks and tabs stay."""
    return escape("".join(c if c in "\n\t" else visible(c) for c in text))


def for_markdown(text: str) -> str:
    """A line as Markdown shows it; figures and formulas stay as they are where no sign of theirs means anything."""
    # What would make a heading, a quotation or an item of a list at the beginning of a line.
    return re.sub(r"^(#{1,6}(?!\S)|>|[+-](?!\w)|\d+(?=[.)](?!\S)))", _escape_first, _inline(text))


def for_cell(text: str) -> str:
    """The same in a cell of a Markdown table."""
    return _inline(text).replace("|", r"\|")


def _inline(text: str) -> str:
    text = re.sub(r"([\\`~$])", r"\\\1", visible(text))
    if text.count("*") > 1 or text.startswith("*") or text.endswith("*"):  # one alone within a line is a star
        text = text.replace("*", r"\*")
    # An underscore within a word is one, and so is a single one; brackets make a link only in pairs; "a < b" is no tag.
    if _OPENING_UNDERSCORE.search(text) and len(_OUTER_UNDERSCORE.findall(text)) > 1:
        text = _OUTER_UNDERSCORE.sub(r"\_", text)
    text = re.sub(r"\](?=[(\[:])", r"\]", text)
    text = re.sub(r"&(?=#?\w+;)", "&amp;", text)
    return re.sub(r"<(?=[A-Za-z/!?])", "&lt;", text)


def _escape_first(match: re.Match[str]) -> str:
    return f"{match[0]}\\" if match[0].isdigit() else f"\\{match[0]}"


def for_latex(text: str) -> str:
    """A line as LaTeX prints it, in text and at the beginning of a table's row."""
    # Two hyphens would be a dash; a first bracket or star, after the end of a row, an option of it.
    parts = ("".join(_LATEX.get(char, char) for char in part) for part in re.split("(?<=-)(?=-)", visible(text)))
    return re.sub(r"^[\[*]", r"{\g<0>}", "{}".join(parts))


def for_figure(text: str) -> str:
    """A name as Matplotlib draws it: a dollar sign starts no formula, and a first underscore hides no legend."""
    text = printable(text).replace("$", r"\$")
    return rf"$\_${text[1:]}" if text.startswith("_") else text


def ascii_signs(text: str) -> str:
    """The signs of our formulas, and any others, in the letters that every encoding has."""
    return "".join(map(_ascii, text))


_OPENING_UNDERSCORE = re.compile(r"(?<![^\W_]|[\u0300-\u036f])_(?=\S)")
_OUTER_UNDERSCORE = re.compile(r"(?<![^\W_]|[\u0300-\u036f])_|_(?![^\W_])")

_LATEX = {
    "\\": r"\textbackslash{}",
    "&": r"\&",
    "%": r"\%",
    "$": r"\$",
    "#": r"\#",
    "_": r"\_",
    "{": r"\{",
    "}": r"\}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': "''",
    "`": r"\textasciigrave{}",
    "·": r"\,",
    "²": r"$^2$",
    "–": "--",
    "∞": r"$\infty$",
    "±": r"$\pm$",
    "−": "$-$",
    "°": r"$^\circ$",
}

_ASCII = {
    "‖": "||",
    "−": "-",
    "–": "-",
    "—": "-",
    "…": "...",
    "·": "*",
    "×": "x",
    "⁄": "/",
    "°": " deg",
    "⁻": "^-",
    "¹": "1",
    "²": "^2",
    "³": "^3",
    "½": "1/2",
    "∞": "inf",
    "√": "sqrt",
    "∈": "in",
    "∂": "d",
    "±": "+-",
    "≤": "<=",
    "≥": ">=",
    "≺": "<",
    "≻": ">",
    "≈": "~",
    "≠": "!=",
    "→": "->",
    "←": "<-",
    "‘": "'",
    "’": "'",
    "“": '"',
    "”": '"',
    "\u0304": "bar",
    "\u0307": "dot",
    "\u0308": "ddot",
    "\u0302": "hat",
    "\u0303": "tilde",
    "━": "-",
    "─": "-",
    "╸": "-",
    "╺": "-",
    "│": "|",
    "•": "*",
    "µ": "u",
}


def _ascii(char: str) -> str:
    if char.isascii():
        return char
    if char in _ASCII:
        return _ASCII[char]
    name = re.fullmatch(r"GREEK (SMALL|CAPITAL) LETTER (\w+)", unicodedata.name(char, ""))
    if name is not None:
        return name[2].lower() if name[1] == "SMALL" else name[2].capitalize()
    plain = "".join(c for c in unicodedata.normalize("NFKD", char) if c.isascii())
    return plain or as_escape(char)
