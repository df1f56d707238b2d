"""Whether files may be read and written, asked before long work is done for them, and the one message if not."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

from asmc_pin.errors import ParameterError, ResultError


def cannot_write(path: str | Path, error: OSError, remedy: str = "") -> ResultError:
    """The one message on a file or folder that cannot be written."""
    mend = f"; {remedy}" if remedy else ""
    return ResultError(path, f"{path} cannot be written: {error.strerror or error}{mend}")


def check_readable(path: str | Path, what: str) -> None:
    """Say that a file cannot be read before anything is done for it.

    Args:
        path: The file.
        what: What it is to be, with its article.

    Raises:
        ResultError: It is missing, a folder, or not for this user.
    """
    number = 0
    try:
        if stat.S_ISDIR(os.stat(path).st_mode):
            number = errno.EISDIR
        elif not os.access(path, os.R_OK):  # not opened: a pipe may never answer
            number = errno.EACCES
    except OSError as error:
        number = error.errno or errno.EIO
    if number:
        raise ResultError(path, f"cannot read {what} {path}: {os.strerror(number)}")


def check_folder(path: str | Path, option: str) -> None:
    """Say that a folder cannot be made or written into before long work is done for it.

    Args:
        path: The folder, which need not be there.
        option: Its name, for the message.

    Raises:
        ParameterError: A file is in its place, or in that of a folder above it, or it is not for this user.
    """
    above = next(each for each in (Path(path), *Path(os.path.abspath(path)).parents) if each.exists())
    if not above.is_dir():
        raise ParameterError(option, f"{above} is a file, a folder expected; give another name")
    if not os.access(above, os.W_OK):
        raise ParameterError(option, f"{above} is not a folder that may be written into; give another one")


_INPUTS = frozenset({".urdf", ".xacro", ".xml", ".toml", ".csv", ".py", ".stl", ".dae", ".obj"})
"""Endings of files that people wrote: a page or a certificate never takes the place of one."""


def check_writable(path: str | Path) -> None:
    """Say that a file cannot be written before long work is done for it.

    Raises:
        ResultError: Its folder is missing or closed, a folder is in its place, or somebody's input is.
    """
    target = Path(os.path.realpath(path))
    if target.is_file() and target.suffix.lower() in _INPUTS:
        raise ResultError(path, f"{path} is there and, by its ending, an input that is not ours; give another name")
    number = 0
    if target.is_dir():
        number = errno.EISDIR
    elif not target.parent.is_dir():
        number = errno.ENOTDIR if target.parent.exists() else errno.ENOENT
    elif not os.access(target if target.exists() else target.parent, os.W_OK):
        number = errno.EACCES
    if number:
        raise cannot_write(path, OSError(number, os.strerror(number)))
