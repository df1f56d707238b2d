"""Moments of a run that are the same on a slow machine and on a busy one, to interrupt or kill it at.

A moment is so many calls of functions after a beginning, or so many files that were opened in a folder.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from types import FrameType
from typing import Any

_CALLS = ("call", "c_call")


def after_calls(number: int, then: Callable[[], object]) -> None:
    """Do something once, at the so-manieth call of any function of this thread from here on, Python's or C's."""
    left = number

    def look(_frame: FrameType, event: str, _argument: object) -> None:
        nonlocal left
        left -= event in _CALLS
        if left <= 0:
            sys.setprofile(None)
            then()

    sys.setprofile(look)


def calls(work: Callable[[], object]) -> int:
    """How many calls a piece of work makes."""
    made = 0

    def look(_frame: FrameType, event: str, _argument: object) -> None:
        nonlocal made
        made += event in _CALLS

    sys.setprofile(look)
    try:
        work()
    finally:
        sys.setprofile(None)
    return made


def when_opened(part: str, number: int, then: Callable[[], object]) -> None:
    """Do something once, as the so-manieth file is about to be opened whose path has this part."""
    left = number

    def look(event: str, arguments: tuple[Any, ...]) -> None:
        nonlocal left
        if event == "open" and part in str(arguments[0]):
            left -= 1
            if left == 0:
                then()

    sys.addaudithook(look)
