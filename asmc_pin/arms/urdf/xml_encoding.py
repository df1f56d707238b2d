"""From the bytes of an XML file to text: one reading for every parser, whatever the file says of its encoding."""

from __future__ import annotations

import codecs
import re
from pathlib import Path

from asmc_pin.disk.reading import shown
from asmc_pin.errors import ArmError
from asmc_pin.words.text import printable

# One byte, one character, and ASCII in the lower half. Python knows others by name that are no text at all (rot13,
# hex), that are not for files (idna), or whose bytes a parser may take for markup (utf-7, gbk).
_READ = re.compile(r"utf-8|ascii|iso8859-\d+|cp125\d|koi8-[rut]|mac-roman")
_DECLARED = re.compile(rb"""^<\?xml\s[^>]*?\bencoding\s*=\s*["']([^"'>]*)["'][^>]*\?>""")
_VERSION = re.compile(r"""^(<\?xml\s+version\s*=\s*)(["'])[^"'>]*\2""")
_ENCODING = re.compile(r"""^(<\?xml\s[^>]*?)\s*\bencoding\s*=\s*["'][^"'>]*["']""")


def decode_xml(path: Path, data: bytes) -> str:
    """The text of an XML file as it stands.

    Args:
        path: The file, for messages.
        data: Its bytes.

    Raises:
        ArmError: An encoding that is not read, or bytes that are none of its characters.
    """
    name, given = _encoding(path, data)
    try:
        return data.decode(name)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ArmError(
            path,
            f"{shown(path)}: line {line}, byte {error.start}: not well-formed XML, as this is no {given}. Save the "
            'file as UTF-8, or name its encoding in the first line: <?xml version="1.0" encoding="…"?>',
        ) from None


def without_declared_encoding(text: str) -> str:
    """The same without a mark or a word on its encoding, for a parser that is given it as UTF-8; no line moves."""
    return _ENCODING.sub(r"\1", text.removeprefix("\ufeff"), count=1)


def with_known_version(text: str) -> str:
    """The same as XML 1.0, whatever version it says: Pinocchio's reader does not ask, and some tools write 0.0."""
    return _VERSION.sub(r"\g<1>\g<2>1.0\2", text, count=1)


def _encoding(path: Path, data: bytes) -> tuple[str, str]:
    """Python's name of the encoding, and how to speak of it."""
    if data.startswith(codecs.BOM_UTF8):
        return "utf-8", "UTF-8"
    if data.startswith((codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE)):
        raise ArmError(path, _not_read(path, "it begins as UTF-32"))
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16", "UTF-16"
    if data.startswith((b"<\0", b"\0<")):  # without a mark, but plain enough
        return ("utf-16-le" if data[0] else "utf-16-be"), "UTF-16"
    match = _DECLARED.match(data[:1000])
    if match is None:
        return "utf-8", "UTF-8"
    given = match[1].decode("latin-1")
    try:
        name = codecs.lookup(given).name
    except (LookupError, ValueError):
        name = ""
    if not _READ.fullmatch(name):
        raise ArmError(path, _not_read(path, f'its first line says encoding="{printable(given)}"'))
    return name, printable(given)


def _not_read(path: Path, why: str) -> str:
    return (
        f'{shown(path)}: {why}, which is not read here. Save the file as UTF-8, with encoding="UTF-8" in its first line'
    )
