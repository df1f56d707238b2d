"""What is being written and not in its place yet: its name, its lock, and what a killed run left of it.

It lies beside its place as ``.NAME.PID.TOKEN.new``, a former folder that makes room for it as ``….old``. Its writer
holds a lock on it, which the system takes away with the process, so that the next run can tell what is left over from
what somebody is writing.
"""

from __future__ import annotations

import hashlib
import os
import re
import secrets
import shutil
import time
from contextlib import suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows: nothing is taken for a leftover there
    fcntl = None  # type: ignore[assignment]

_LONGEST = 100
"""Characters of a target's name that its temporary's name repeats; file systems end at 255 bytes."""


_YOUNG = 60.0
"""Age in s up to which a temporary of a running process may not be locked yet."""


IN_WORK: dict[Path, Path | None] = {}
"""What this process is writing; beside a folder that made room, the place where it belongs."""


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
    for made in list(IN_WORK):
        discard(made)


def beside(path: Path, kind: str) -> Path:
    """A name beside a place that nobody has, ``new`` or ``old``."""
    return path.with_name(f".{_stem(path)}.{os.getpid()}.{secrets.token_hex(4)}.{kind}")


def _stem(path: Path) -> str:
    name = path.name
    if len(os.fsencode(name)) <= _LONGEST:
        return name
    return hashlib.sha256(os.fsencode(name)).hexdigest()


def discard(made: Path) -> None:
    """Remove a temporary that did not take its place; a folder that made room goes back where its place is empty."""
    with suppress(OSError):
        _remove(made, IN_WORK.get(made))
    IN_WORK.pop(made, None)


def _remove(made: Path, home: Path | None) -> None:
    if home is not None and not home.exists() and made.exists():
        os.replace(made, home)
    elif made.is_dir():
        shutil.rmtree(made, ignore_errors=True)
    else:
        made.unlink(missing_ok=True)


def take_lock(descriptor: int) -> bool:
    """Lock an open file or folder until it is closed; whether that could be had."""
    if fcntl is None:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def locked(path: Path) -> int | None:
    """An open descriptor that holds the lock of a file or folder; None where it cannot be had."""
    if fcntl is None:
        return None
    descriptor = os.open(path, os.O_RDONLY)
    if take_lock(descriptor):
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
    descriptor = locked(leftover)
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
