"""How code with loops of a few rounds is compiled: without vectorising them.

LLVM vectorises a loop over several arrays behind a test that none of them overlap. Over the six joints of an arm that
test costs ten times the loop.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numba
from numba.core import config
from numba.core.compiler import Compiler

Function = TypeVar("Function", bound=Callable[..., Any])

_settings: Any = config  # numba has no types
_compiler: Any = Compiler


class _ShortLoops(_compiler):  # type: ignore[misc]
    """Numba's compiler with LLVM's vectoriser of loops switched off."""

    def compile_extra(self, func: Any) -> Any:
        before = _settings.LOOP_VECTORIZE
        _settings.LOOP_VECTORIZE = 0
        try:
            return super().compile_extra(func)
        finally:
            _settings.LOOP_VECTORIZE = before


ALLOCATING: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "pipeline_class": _ShortLoops}
"""Options of `numba.njit`; a division by 0 gives inf or NaN, as numpy's does."""
OPTIONS: dict[str, Any] = {**ALLOCATING, "_nrt": False}
"""The same for a function that makes no arrays: it does not count references to those that it is handed either, which
numba does with atomic instructions, some nanoseconds each."""


def short_loops(function: Function) -> Function:
    """Decorator: compile a function whose loops go over joints, links or axes, and which makes no arrays."""
    compiled: Function = numba.njit(**OPTIONS)(function)
    return compiled


def inlined(function: Function) -> Function:
    """Decorator: as `short_loops`, for a piece of one other function, into which it is compiled."""
    compiled: Function = numba.njit(forceinline=True, **OPTIONS)(function)
    return compiled


def with_room(function: Function) -> Function:
    """Decorator: the same for a function that makes arrays to work in, and then calls functions that make none."""
    compiled: Function = numba.njit(**ALLOCATING)(function)
    return compiled


def as_written(function: Function) -> Function:
    """What was decorated, in Python: a formula of numbers is one of arrays as well."""
    written: Function = getattr(function, "py_func", function)
    return written
