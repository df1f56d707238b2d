"""Writing files and folders whole or not at all: until the new one is complete on the disk, a former one stays."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from asmc_pin.disk.file_access import cannot_write
from asmc_pin.disk.sole_writer import NO_ROOM
from asmc_pin.disk.unfinished import IN_WORK, beside, discard, locked, remove_leftovers, take_lock
from asmc_pin.words.interface import option_words


def write_whole(path: str | Path, content: str | bytes) -> None:
    """Write a file, whole or not at all: a former one stays as it was until the new one is complete on the disk.

    Args:
        path: The file. Through a link the file behind it is replaced; a device or a pipe is written to.
        content: Bytes, or text, which becomes UTF-8 with the same bytes on every system.

    Raises:
        ResultError: It cannot be written, in one message.
    """
    data = content.encode("utf-8", "backslashreplace") if isinstance(content, str) else content
    try:
        target = Path(os.path.realpath(path))
        if target.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        if target.exists() and not target.is_file():
            # A pipe that nobody reads would be waited for without end.
            with open(os.open(target, os.O_WRONLY | os.O_NONBLOCK), "wb") as file:
                os.set_blocking(file.fileno(), True)
                file.write(data)
            return
        if target.exists() and not os.access(target, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        remove_leftovers(target)
        _write_beside(target, data)
    except OSError as error:
        raise cannot_write(path, error) from error


def _write_beside(target: Path, data: bytes) -> None:
    with _beside_file(target) as file:
        file.write(data)


@contextmanager
def whole_file(path: Path) -> Iterator[BinaryIO]:
    """A file to write piece by piece, which takes its place when the block ends without an exception.

    For what is larger than memory ought to be; see `write_whole`.

    Yields:
        An open file beside it.

    Raises:
        ResultError: It cannot be written, in one message.
    """
    try:
        remove_leftovers(path)
        with _beside_file(path) as file:
            yield file
    except OSError as error:
        raise cannot_write(path, error) from error


@contextmanager
def _beside_file(target: Path) -> Iterator[BinaryIO]:
    made = beside(target, "new")
    IN_WORK[made] = None
    try:
        # As any new file: with the rights that the user's mask leaves, or with those of the file that it replaces.
        with open(os.open(made, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666), "wb") as file:
            take_lock(file.fileno())
            if target.exists():
                made.chmod(stat.S_IMODE(target.stat().st_mode))
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.replace(made, target)
    finally:
        discard(made)


@contextmanager
def whole_folder(path: Path, check: Callable[[], None] = lambda: None) -> Iterator[Path]:
    """A folder to write into, which takes its place when the block ends without an exception.

    Until then a former folder stays what it was; after an exception nothing is left of the new one.

    Args:
        path: Where the folder is to be.
        check: Asked before anything is written, and again before the place is taken; raises where it may not be.

    Yields:
        An empty folder beside it, on the same file system.

    Raises:
        ResultError: It cannot be written, in one message.
    """
    check()
    made = beside(path, "new")
    IN_WORK[made] = None
    try:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            remove_leftovers(path)
            made.mkdir()
            lock = locked(made)
        except OSError as error:
            # Not the system's own words alone: they name a folder that nobody asked for.
            raise cannot_write(path, error, f"give another folder with {option_words('out')}") from error
        try:
            yield made
            check()  # another run may have been quicker
            _put_in_place(made, path)
        except OSError as error:
            if error.errno not in NO_ROOM:
                raise
            raise cannot_write(path, error) from error
        finally:
            if lock is not None:
                os.close(lock)
    finally:
        discard(made)


def _put_in_place(made: Path, path: Path) -> None:
    if not path.exists():
        os.replace(made, path)
        return
    old = beside(path, "old")
    IN_WORK[old] = path
    lock = locked(path)  # the lock goes with the folder
    try:
        os.replace(path, old)
        os.replace(made, path)
    finally:
        discard(old)
        if lock is not None:
            os.close(lock)
