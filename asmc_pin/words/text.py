"""Names that other people chose, on their way to a terminal, a page or a file."""

from __future__ import annotations

import re
import unicodedata
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal

_LONGEST, _LONGEST_LINE, _MOST_LINES = 200, 2000, 40

_WORD = re.compile(r"[\w./+#()\[\]-]+")

_UNSEEN = {
    0x034F,
    0x115F,
    0x1160,
    0x17B4,
    0x17B5,
    0x2800,
    0x3164,
    0xFFA0,
    *range(0x180B, 0x1810),
    *range(0xFE00, 0xFE10),
}
"""Letters and marks that show as nothing or as a blank."""

_STRIKING = {*range(0x0334, 0x0339), *range(0x20D0, 0x20F1)}
"""Marks that strike through or surround what stands before them."""


def printable(text: str) -> str:
    r"""A name as it may be shown: no control, direction or line-breaking characters, and not without end.

    A terminal obeys escape codes, and a reader takes a line break for the end of what a tool says.

    Args:
        text: Any text, from a file that a stranger may have written.

    Returns:
        The same where it is harmless; characters of Unicode's categories C and Z (but for the space) as ``\\xNN`` or
        ``\\uNNNN``, and the middle of a very long one left out.
    """
    return _shown(text, _LONGEST)


def visible(text: str) -> str:
    """A line of any length as `printable` shows it."""
    return "".join(c if _harmless(c) else as_escape(c) for c in text)


def message_text(text: str) -> str:
    """A message as it may be shown: line by line as `visible`, but not without end."""
    lines = text.split("\n")
    if len(lines) > _MOST_LINES:
        lines = [*lines[:_MOST_LINES], f"  … and {len(lines) - _MOST_LINES} lines more"]
    return "\n".join(_shown(line, _LONGEST_LINE) for line in lines)


def as_number(text: str) -> float:
    """A number as files write it; Python alone would also take ``1_000`` and the digits of other scripts.

    Raises:
        ValueError: It is none.
    """
    if not text.isascii() or "_" in text:
        raise ValueError(f"{printable(text)!r} is not a number")
    return float(text)


def _shown(text: str, longest: int) -> str:
    """As `visible`, and short also where one character becomes a code of many."""
    return _shortened(visible(_shortened(text, longest)), longest)


def _shortened(text: str, longest: int) -> str:
    return text if len(text) <= longest else f"{text[: longest // 2]}…{text[-longest // 4 :]}"


def as_escape(character: str) -> str:
    r"""A character as ``\\xNN``, ``\\uNNNN`` or ``\\UNNNNNNNN``."""
    code = ord(character)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def quoted(name: str) -> str:
    """A name within a sentence: one word as it is, all else in quotes that it cannot close.

    So a joint named ``shoulder -3:3 rad, elbow`` is not taken for two joints and what the tool says of them.
    """
    if _WORD.fullmatch(name) and printable(name) == name:
        return name
    return "'" + printable(name).replace("\\", "\\\\").replace("'", "\\'") + "'"


def exact(value: float) -> str:
    """A number with as many digits as tell it from every other float: what is proven up to it is not proven beyond."""
    return repr(float(value)).removesuffix(".0")


def rounded_down(value: float, digits: int = 6) -> str:
    """A number with so many digits that is not above the value."""
    return _rounded(value, digits, ROUND_FLOOR)


def rounded_up(value: float, digits: int = 6) -> str:
    """A number with so many digits that is not below the value."""
    return _rounded(value, digits, ROUND_CEILING)


def _rounded(value: float, digits: int, way: str) -> str:
    rounded = Context(prec=digits, rounding=way).create_decimal(Decimal(value))
    return f"{float(rounded):.{digits}g}"


def _harmless(character: str) -> bool:
    code = ord(character)
    if character == " ":
        return True
    return unicodedata.category(character)[0] not in "CZ" and code not in _UNSEEN and code not in _STRIKING


def counted(count: int, one: str, many: str = "") -> str:
    """So many of a thing: ``1 box``, ``2 boxes``; its plural has an s where `many` is empty."""
    return f"{count} {one if count == 1 else many or one + 's'}"
