"""Wall time of a computation, without what numba compiles on the way: that happens once, and says nothing about it."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from numba.core import event


class Clock:
    """Runs from where it is made."""

    def __init__(self) -> None:
        self._compiled_before = _watch.spent
        self._began = time.perf_counter()

    def seconds(self) -> float:
        """Time since then without compiling, s."""
        return time.perf_counter() - self._began - self.compiling()

    def compiling(self) -> float:
        """Time since then that was spent compiling, s."""
        return _watch.spent - self._compiled_before


def tell_of_compiling(tell: Callable[[], None] | None) -> None:
    """Have a function called when numba next compiles something that its cache does not have; once."""
    _watch.tell = tell


class _Watch(event.Listener):
    """Told by numba, which compiles on one thread at a time; of what it finds in its cache there is no event."""

    def __init__(self) -> None:
        self.spent = 0.0
        self.tell: Callable[[], None] | None = None
        self._depth = 0
        self._since = 0.0

    def on_start(self, event: Any) -> None:
        """Something begins to be compiled, perhaps for something else that is being compiled."""
        self._depth += 1
        if self._depth == 1:
            self._since = time.perf_counter()
            tell, self.tell = self.tell, None
            if tell is not None:
                tell()

    def on_end(self, event: Any) -> None:
        """It is done."""
        self._depth -= 1
        if self._depth == 0:
            self.spent += time.perf_counter() - self._since


_watch = _Watch()
_register: Any = event.register  # numba has no types
_register("numba:compile", _watch)
