"""Names that other people chose, on their way to a terminal, a page or a file."""

from __future__ import annotations

import unicodedata

_LONGEST = 200


def printable(text: str) -> str:
    r"""A name as it may be shown: no control, direction or line-breaking characters, and not without end.

    A terminal obeys escape codes, and a reader takes a line break for the end of what a tool says.

    Args:
        text: Any text, from a file that a stranger may have written.

    Returns:
        The same where it is harmless; characters of Unicode's categories C and Z (but for the space) as ``\\xNN`` or
        ``\\uNNNN``, and the middle of a very long one left out.
    """
    if len(text) > _LONGEST:
        text = f"{text[: _LONGEST // 2]}…{text[-_LONGEST // 4 :]}"
    return "".join(c if c == " " or unicodedata.category(c)[0] not in "CZ" else _escaped(c) for c in text)


def _escaped(character: str) -> str:
    code = ord(character)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"
