"""A folder that a long run fills file by file: one run at a time, and a full disk said in one message."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from asmc_pin.disk.file_access import cannot_write
from asmc_pin.errors import ResultError
from asmc_pin.words.interface import option_words

try:
    import fcntl
except ImportError:  # Windows: nothing is locked there
    fcntl = None  # type: ignore[assignment]

NO_ROOM = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
"""What a disk that is full answers, or a limit of what this user may write."""


@contextmanager
def sole_writer(folder: Path) -> Iterator[None]:
    """In the block no other run of this machine writes into a folder: figures of two would be mixed in it.

    The lock is the folder's own, and goes with the process. Where the file system has none, nothing is locked.

    Args:
        folder: It exists.

    Raises:
        ResultError: Another run is at it, or in the block there was no room on the disk.
    """
    descriptor = os.open(folder, os.O_RDONLY) if fcntl is not None else None
    try:
        if descriptor is not None:
            _lock(descriptor, folder)
        yield
    except OSError as error:
        # Libraries that write by themselves do not say where.
        if error.filename is not None or error.errno not in NO_ROOM:
            raise
        raise cannot_write(folder, error, "make room, and start again: what is done is kept") from error
    finally:
        if descriptor is not None:
            os.close(descriptor)


def _lock(descriptor: int, folder: Path) -> None:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise ResultError(
            folder,
            f"another run is writing into {folder}; "
            f"wait for its end, or give another folder with {option_words('out')}",
        ) from None
    except OSError:
        return
