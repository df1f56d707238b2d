"""The standard streams: neither a reader that leaves nor an encoding without our signs changes a status."""

from __future__ import annotations

import codecs
import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO

from asmc_pin.errors import ResultError
from asmc_pin.words.media import ascii_signs

_ERRORS = "asmc-pin.signs"


@contextmanager
def guarded(*, keep: bool) -> Iterator[None]:
    """In the block, standard output and error swallow what nobody reads, and replace what they cannot show.

    Args:
        keep: Whether that lasts beyond the block.
    """
    codecs.register_error(_ERRORS, _replaced)
    _open_descriptors()
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = _patient(before[0], "standard output"), _patient(before[1], None)
    try:
        yield
    finally:
        if not keep:
            for stream in (sys.stdout, sys.stderr):
                stream.flush()
            sys.stdout, sys.stderr = before


def is_unicode() -> bool:
    """Whether standard output has all signs."""
    return codecs.lookup(sys.stdout.encoding or "ascii").name.startswith("utf")


class _Patient(io.RawIOBase):
    """A descriptor to write to, until its reader has left."""

    def __init__(self, descriptor: int, name: str | None) -> None:
        self._descriptor, self._name, self._over = descriptor, name, False

    def writable(self) -> bool:
        return True

    def fileno(self) -> int:
        return self._descriptor

    def isatty(self) -> bool:
        return os.isatty(self._descriptor)

    def write(self, data: Any) -> int:
        size = memoryview(data).nbytes
        if self._over:
            return size
        try:
            return os.write(self._descriptor, data)
        except ConnectionError:
            self._over = True
        except OSError as error:
            self._over = True  # told once
            if self._name is not None:
                raise ResultError(self._name, f"{self._name} cannot be written: {error.strerror or error}") from error
        return size


def _patient(stream: TextIO | None, name: str | None) -> TextIO:
    if stream is None:  # closed before the process began
        return open(os.devnull, "w", encoding="utf-8")
    try:
        descriptor = stream.fileno()
        stream.flush()
    except (OSError, ValueError):  # no file behind it, as where a test listens
        return stream
    raw = _Patient(descriptor, name)
    return io.TextIOWrapper(
        io.BufferedWriter(raw),
        encoding=stream.encoding,
        errors=_ERRORS,
        line_buffering=name is None or raw.isatty(),
    )


def _open_descriptors() -> None:
    """Where one of the first three is closed, the next file to be opened would get its number, and our messages."""
    while (descriptor := os.open(os.devnull, os.O_RDWR)) < 3:
        pass
    os.close(descriptor)


def _replaced(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return ascii_signs(error.object[error.start : error.end]), error.end
