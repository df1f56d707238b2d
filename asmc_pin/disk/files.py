"""Writing files and folders whole or not at all, and removing what a killed run left of them.

What is being written lies beside its place as ``.NAME.PID.TOKEN.new``, a former folder that makes room for it as
``….old``. Its writer holds a lock on it, which the system takes away with the process, so that the next run can tell
what is left over from what somebody is writing.
"""

from __future__ import annotations

import errno
import hashlib
import os
import re
import secrets
import shutil
import stat
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from asmc_pin.errors import ResultError

try:
    import fcntl
except ImportError:  # Windows: nothing is taken for a leftover there
    fcntl = None  # type: ignore[assignment]

_LONGEST = 100
"""Characters of a target's name that its temporary's name repeats; file systems end at 255 bytes."""

_YOUNG = 60.0
"""Age in s up to which a temporary of a running process may not be locked yet."""

_NO_ROOM = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}

_live: dict[Path, Path | None] = {}
"""What this process is writing; beside a folder that made room, the place where it belongs."""


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
    made = _beside(target, "new")
    _live[made] = None
    try:
        # As any new file: with the rights that the user's mask leaves, or with those of the file that it replaces.
        with open(os.open(made, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666), "wb") as file:
            _lock(file.fileno())
            if target.exists():
                made.chmod(stat.S_IMODE(target.stat().st_mode))
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.replace(made, target)
    finally:
        _discard(made)


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
    made = _beside(path, "new")
    _live[made] = None
    try:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            remove_leftovers(path)
            made.mkdir()
            lock = _locked(made)
        except OSError as error:
            # Not the system's own words alone: they name a folder that nobody asked for.
            raise cannot_write(path, error, "give another folder with --out") from error
        try:
            yield made
            check()  # another run may have been quicker
            _put_in_place(made, path)
        except OSError as error:
            if error.errno not in _NO_ROOM:
                raise
            raise cannot_write(path, error) from error
        finally:
            if lock is not None:
                os.close(lock)
    finally:
        _discard(made)


def _put_in_place(made: Path, path: Path) -> None:
    if not path.exists():
        os.replace(made, path)
        return
    old = _beside(path, "old")
    _live[old] = path
    lock = _locked(path)  # the lock goes with the folder
    try:
        os.replace(path, old)
        os.replace(made, path)
    finally:
        _discard(old)
        if lock is not None:
            os.close(lock)


def remove_leftovers(path: Path) -> None:
    """Remove what killed runs left beside a place, and put back a folder that had made room for one that never came.

    What a running process is writing is left alone.
    """
    pattern = re.compile(re.escape(f".{_stem(path)}.") + r"(\d+)\.[0-9a-f]{8}\.(new|old)")
    try:
        named = [(pattern.fullmatch(name), path.parent / name) for name in os.listdir(path.parent)]
    except OSError:
        return
    found = [(place, int(match[1]), match[2]) for match, place in named if match is not None]
    for leftover, pid, kind in sorted(found, key=lambda item: _changed(item[0]), reverse=True):  # the newest first
        with suppress(OSError):
            if _is_dead(leftover, pid):
                _remove(leftover, path if kind == "old" else None)


def discard_unfinished() -> None:
    """Remove all that this process has not finished: for an end without unwinding."""
    for made in list(_live):
        _discard(made)


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


def _beside(path: Path, kind: str) -> Path:
    return path.with_name(f".{_stem(path)}.{os.getpid()}.{secrets.token_hex(4)}.{kind}")


def _stem(path: Path) -> str:
    name = path.name
    if len(os.fsencode(name)) <= _LONGEST:
        return name
    return hashlib.sha256(os.fsencode(name)).hexdigest()


def _discard(made: Path) -> None:
    """Remove a temporary that did not take its place; a folder that made room goes back where its place is empty."""
    with suppress(OSError):
        _remove(made, _live.get(made))
    _live.pop(made, None)


def _remove(made: Path, home: Path | None) -> None:
    if home is not None and not home.exists() and made.exists():
        os.replace(made, home)
    elif made.is_dir():
        shutil.rmtree(made, ignore_errors=True)
    else:
        made.unlink(missing_ok=True)


def _lock(descriptor: int) -> bool:
    if fcntl is None:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _locked(path: Path) -> int | None:
    """An open descriptor that holds the lock of a file or folder; None where it cannot be had."""
    if fcntl is None:
        return None
    descriptor = os.open(path, os.O_RDONLY)
    if _lock(descriptor):
        return descriptor
    os.close(descriptor)
    return None


def _changed(path: Path) -> float:
    try:
        return path.lstat().st_ctime
    except OSError:
        return 0.0


def _is_dead(leftover: Path, pid: int) -> bool:
    """Whether nobody writes it any more."""
    if _is_running(pid) and time.time() - _changed(leftover) < _YOUNG:
        return False
    descriptor = _locked(leftover)
    if descriptor is None:
        return False
    os.close(descriptor)
    return True


def _is_running(pid: int) -> bool:
    if fcntl is None:
        return True
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    return True
