"""Where errors become one message and a status; what nobody foresaw becomes status 4, and a file with its traceback."""

from __future__ import annotations

import atexit
import errno
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from asmc_pin.cli import interrupt
from asmc_pin.cli.console import note
from asmc_pin.cli.interrupt import INTERRUPTED, MESSAGE
from asmc_pin.errors import AsmcPinError
from asmc_pin.words.text import printable

BAD_INPUT, FAULT = 2, 4

_PACKAGE = Path(__file__).resolve().parent.parent

_OF_THE_WORLD = {
    getattr(errno, name)
    for name in (
        *("EACCES", "EPERM", "EROFS", "ENOSPC", "EDQUOT", "EFBIG", "EIO", "EMFILE", "ENFILE", "ENOMEM", "ENAMETOOLONG"),
        *("EEXIST", "ENOTEMPTY", "EBUSY", "ETXTBSY", "ELOOP", "ENODEV", "ENXIO"),
        *("ESTALE", "ETIMEDOUT", "EADDRINUSE", "EADDRNOTAVAIL"),
    )
    if hasattr(errno, name)
}
"""What a disk, its rights and its limits may answer; any other number of an OSError is a fault of ours."""

_seen = False
_status: int | None = None


@contextmanager
def caught(*, keep: bool) -> Iterator[None]:
    """In the block, exceptions of threads and of clean-up code are faults too, and put no traceback on the terminal.

    Args:
        keep: Whether that lasts beyond the block, to the end of the process.
    """
    global _seen, _status
    _seen, _status = False, None
    before = threading.excepthook, sys.unraisablehook
    threading.excepthook = lambda args: _report_unless_exit(args.exc_value)
    sys.unraisablehook = lambda args: _report_unless_exit(args.exc_value)
    if keep:
        atexit.register(_end)  # the first to be registered, so the last to be called
    try:
        yield
    finally:
        if not keep:
            threading.excepthook, sys.unraisablehook = before


def final(status: int) -> int:
    """The status of the process: that of its command, unless there was a fault elsewhere, or Ctrl-C."""
    global _status
    if _seen:
        status = FAULT
    elif interrupt.asked() and status != INTERRUPTED:
        note("interrupted; what is printed is what was known by then")
        status = INTERRUPTED
    _status = status
    return status


def status_of(error: BaseException) -> int:
    """Say what an exception means, and give the status to end with."""
    if isinstance(error, AsmcPinError):
        note(str(error))
        return BAD_INPUT
    if isinstance(error, KeyboardInterrupt):
        note(MESSAGE)
        return INTERRUPTED
    if isinstance(error, MemoryError):
        note(f"out of memory: {error or 'the run is too large'}; shorten it, or take fewer samples or trials")
        return BAD_INPUT
    if isinstance(error, OSError) and _is_of_the_world(error):
        note(f"{error.strerror}{f': {error.filename}' if error.filename else ''}")
        return BAD_INPUT
    # Usage errors: typer carries click's classes under names of its own that moved between its releases.
    if hasattr(error, "format_message") and hasattr(error, "exit_code"):
        context = getattr(error, "ctx", None)
        hint = f" (see '{context.command_path} --help')" if context is not None else ""
        note(f"{_usage_words(error).rstrip('.')}{hint}")
        return BAD_INPUT
    report_fault(error)
    return FAULT


def _usage_words(error: Any) -> str:
    """A usage error as typer says it, with what was typed where it does not say so."""
    said = str(error.format_message()).replace("Value error, ", "")
    if "Input should be" in said and hasattr(error.__cause__, "errors"):
        given = error.__cause__.errors()[0]["input"]
        return said.replace("Input should be", f"'{printable(str(given))}' given, expected")
    return said


def report_fault(error: BaseException) -> None:
    """Write the traceback of what nobody foresaw to a file, and say where it is."""
    global _seen
    _seen = True
    what = " ".join(f"{type(error).__name__}: {printable(str(error))}".split()).rstrip(": ")
    note(f"a fault of asmc-pin itself, {what}; {_recorded(error)}")


def _recorded(error: BaseException) -> str:
    import platform
    import tempfile
    import traceback
    from importlib.metadata import version

    text = "".join(traceback.format_exception(error))
    head = f"asmc-pin {version('asmc-pin')}, Python {sys.version.split()[0]}, {platform.platform()}\n{sys.argv[1:]}\n\n"
    for folder in (None, os.curdir):
        try:
            descriptor, name = tempfile.mkstemp(prefix="asmc-pin-fault-", suffix=".txt", dir=folder)
            with open(descriptor, "w", encoding="utf-8", errors="backslashreplace") as file:
                file.write(head + text)
        except OSError:
            continue
        return f"please report it with the traceback in {name}"
    return "its traceback could not be written, neither to the system's folder for such files nor here"


def _is_of_the_world(error: OSError) -> bool:
    if isinstance(error, FileNotFoundError | NotADirectoryError | IsADirectoryError):
        # Neither a missing file that nobody asked for by name is the user's, nor one of the package itself.
        named = isinstance(error.filename, str | bytes | os.PathLike)
        return named and _PACKAGE not in Path(os.path.abspath(os.fsdecode(error.filename))).parents
    return error.errno in _OF_THE_WORLD


def _report_unless_exit(error: Any) -> None:
    if error is not None and not isinstance(error, SystemExit):
        report_fault(error)


def _end() -> None:
    """End here: the rest of Python's own clearing up takes a while, and in it Ctrl-C finds no handler of ours."""
    if _status is not None:
        for stream in (sys.stdout, sys.stderr):
            with suppress(Exception):
                stream.flush()
        os._exit(FAULT if _seen else _status)
