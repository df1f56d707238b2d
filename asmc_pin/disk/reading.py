"""Reading a file that someone gave: a regular file, of a size that is possible, and nothing of it before that is known.

``/dev/zero`` has no end, a named pipe may never begin, and a sparse file of terabytes costs nothing to send.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path

from asmc_pin.errors import AsmcPinError, ParameterError
from asmc_pin.words.text import printable

Fail = Callable[[str], AsmcPinError]
"""Makes the error of the reader's own kind from a message."""


def user_path(text: str | Path) -> Path:
    """A path as a user writes it; ``~`` is the home folder, and stays as it is where nobody's is meant.

    Raises:
        ParameterError: It is neither text nor a path.
    """
    if not isinstance(text, str | os.PathLike):
        raise ParameterError("path", f"{text!r} given, a path or a name expected")
    path = Path(text)
    try:
        return path.expanduser()
    except RuntimeError:
        return path


def check_file(path: Path, largest: int, what: str, fail: Fail) -> int:
    """Refuse what is no regular file, or larger than any file of its kind, without opening it.

    Args:
        path: The file.
        largest: Bytes that are read at most.
        what: What it should be, for the message, such as ``"a URDF"``.
        fail: Makes the error.

    Returns:
        Its size, bytes.

    Raises:
        AsmcPinError: What `fail` makes; it is missing, a folder, a device, a pipe, or too large.
    """
    try:
        found = os.stat(path)
    except (OSError, ValueError) as error:
        raise fail(f"{shown(path)}: cannot be read ({reason(error)})") from None
    return _checked(path, found, largest, what, fail)


def read_file(path: Path, largest: int, what: str, fail: Fail) -> bytes:
    """The bytes of a file that passes `check_file`; arguments and errors as there."""
    try:
        # Opening a pipe that nobody writes to waits for ever, unless it is told not to.
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
        try:
            _checked(path, os.fstat(descriptor), largest, what, fail)
            with open(descriptor, "rb", closefd=False) as file:
                data = file.read(largest + 1)
        finally:
            os.close(descriptor)
    except AsmcPinError:  # some are ValueErrors, and said what is wrong
        raise
    except (OSError, ValueError) as error:
        raise fail(f"{shown(path)}: cannot be read ({reason(error)})") from None
    if len(data) > largest:  # it grows while it is read
        raise fail(_too_large(path, len(data), largest, what))
    return data


def _checked(path: Path, found: os.stat_result, largest: int, what: str, fail: Fail) -> int:
    if stat.S_ISDIR(found.st_mode):
        raise fail(f"{shown(path)}: is a folder, not {what} file")
    if not stat.S_ISREG(found.st_mode):
        kind = "a pipe" if stat.S_ISFIFO(found.st_mode) else "no file but a device or a socket"
        raise fail(f"{shown(path)}: is {kind}; {what} is read from a regular file, save it to one first")
    if found.st_size > largest:
        raise fail(_too_large(path, found.st_size, largest, what))
    return found.st_size


def _too_large(path: Path, size: int, largest: int, what: str) -> str:
    return f"{shown(path)}: has {size / 1e6:.4g} MB, and {what} of more than {largest / 1e6:.4g} MB is not read"


def reason(error: Exception) -> str:
    """Why the system refused, in few words."""
    return getattr(error, "strerror", None) or str(error)


def shown(path: Path) -> str:
    """A path as it may be printed."""
    return printable(str(path))
