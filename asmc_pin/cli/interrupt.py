"""Ctrl-C: status 130 at any moment.

An exception would not do: third-party imports and callbacks swallow `KeyboardInterrupt`. So the signal's handler itself
removes what is half-written, says so, and ends the process; it asks for nothing that the interrupted code may hold.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType

INTERRUPTED = 130
"""Exit status after Ctrl-C."""

MESSAGE = "interrupted; nothing half-written was left behind"

_asked = False
_stops_short = False


@contextmanager
def at_once(*, keep: bool) -> Iterator[None]:
    """In the block, Ctrl-C ends the process with status 130; where it is ignored (``nohup``) it stays ignored.

    Args:
        keep: Whether that lasts beyond the block.
    """
    global _asked
    _asked = False
    try:
        before = signal.getsignal(signal.SIGINT)
        if before != signal.SIG_IGN:
            signal.signal(signal.SIGINT, _handle)
    except ValueError:  # not the main thread: there is no handler to set
        yield
        return
    try:
        yield
    finally:
        if not keep:
            signal.signal(signal.SIGINT, before)


@contextmanager
def stopping_short() -> Iterator[Callable[[], None]]:
    """In the block, from the first call of what it yields on, the first Ctrl-C raises `KeyboardInterrupt`.

    For work that catches it and hands back what it has; a second Ctrl-C ends the process. Every further call raises it
    again after a Ctrl-C, should somebody have swallowed it.
    """
    global _stops_short

    def go_on() -> None:
        global _stops_short
        if _asked:
            raise KeyboardInterrupt
        _stops_short = True

    try:
        yield go_on
    finally:
        _stops_short = False


def asked() -> bool:
    """Whether Ctrl-C cut short what `stopping_short` guards."""
    return _asked


def _handle(_number: int, _frame: FrameType | None) -> None:
    global _asked
    if _stops_short and not _asked:
        _asked = True
        raise KeyboardInterrupt
    signal.signal(signal.SIGINT, lambda *_: os._exit(INTERRUPTED))  # who presses it again does not want to wait
    try:
        discard = getattr(sys.modules.get("asmc_pin.disk.unfinished"), "discard_unfinished", None)
        if discard is not None:
            discard()
        with suppress(OSError):
            # Past the stream, whose lock the interrupted code may hold. A progress bar goes, and the cursor comes back.
            bar = b"\r\x1b[2K\x1b[?25h" if "rich.progress" in sys.modules and os.isatty(2) else b""
            os.write(2, bar + f"asmc-pin: {MESSAGE}\n".encode())
    finally:
        os._exit(INTERRUPTED)
