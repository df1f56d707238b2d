"""Lines of Markdown that a person can read in an editor: prose is wrapped, tables and code are not."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator

WIDTH = 118
"""Characters in a line of prose, at most."""

_NO_PROSE = ("|", "#", "!", "<", "    ", "```")
# At the beginning of a line these would make a heading, a quotation or an item of a list.
_BEFORE_A_MARK = re.compile(r" (?=(?:[-+*]|#{1,6}|\d+[.)])(?: |$)|>)")


def wrap_prose(text: str) -> str:
    """Wrap paragraphs and items of a Markdown page that stand in one long line; the words stay as they are."""
    return "\n".join(_wrapped_lines(text.split("\n")))


def _wrapped_lines(lines: list[str]) -> Iterator[str]:
    code = False
    for line in lines:
        code ^= line.startswith("```")
        if code or len(line) <= WIDTH or line.startswith(_NO_PROSE):
            yield line
            continue
        mark = re.match(r"(?:[-*]|\d+[.)]) |", line)
        start = mark[0] if mark else ""
        kept = start + _BEFORE_A_MARK.sub("\0", line[len(start) :])
        for part in textwrap.wrap(
            kept, WIDTH, subsequent_indent=" " * len(start), break_long_words=False, break_on_hyphens=False
        ):
            yield part.replace("\0", " ")
