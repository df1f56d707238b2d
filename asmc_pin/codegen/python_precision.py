"""A step as plain Python, so that it can be run in single precision too: numba's compiled one computes in double."""

from __future__ import annotations

import types
from collections.abc import Callable
from typing import Any


def in_python(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function with every compiled function that it calls, and those that they call, as they are written.

    Python rounds an operation of two numbers of a type to that type, as C does, and takes a constant as one of it.
    """
    return _written(function, {})


def _written(function: Callable[..., Any], made: dict[Any, Any]) -> Callable[..., Any]:
    source = getattr(function, "py_func", function)
    if source in made:
        return made[source]  # type: ignore[no-any-return]
    names = dict(source.__globals__)
    copied = types.FunctionType(source.__code__, names, source.__name__, source.__defaults__, source.__closure__)
    made[source] = copied
    for name in source.__code__.co_names:
        if hasattr(names.get(name), "py_func"):
            names[name] = _written(names[name], made)
    # float() of a number of the type in use would leave the type; what is handed to it here has the type already.
    names["float"] = lambda value: value
    return copied
