"""A law's state as rows of numbers, and back: a named tuple of arrays outside, memory of one trial in compiled code."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from typing import Any, TypeVar

import numpy as np

from asmc_pin._typing import Array

State = TypeVar("State")


def _leaves(state: Any) -> Iterator[Any]:
    """What a state holds, in the order of its named tuples, one inside the other."""
    if isinstance(state, tuple):
        for part in state:
            yield from _leaves(part)
    elif state is not None:
        yield state


def as_rows(state: Any, shape: tuple[int, int]) -> tuple[int, Array]:
    """Ticks taken, and memory with a row for each array of the state; shape is (batch, nv), memory (batch, rows, nv).

    A whole number in a state is the number of ticks taken; all else is an array of shape (batch, nv).
    """
    leaves = list(_leaves(state))
    arrays = [leaf for leaf in leaves if not isinstance(leaf, int)]
    memory = np.empty((shape[0], len(arrays), shape[1]))
    for row, array in enumerate(arrays):
        memory[:, row] = array
    return next((leaf for leaf in leaves if isinstance(leaf, int)), 0), memory


def from_rows(like: State, ticks: int, memory: Array) -> State:
    """A state of the same kind as `like` with these ticks taken and this memory, of which its arrays are views."""
    rows = iter(range(memory.shape[1]))

    def made(part: Any) -> Any:
        if isinstance(part, tuple):
            return type(part)(*map(made, part))
        return part if part is None else ticks if isinstance(part, int) else memory[:, next(rows)]

    state: State = made(like)
    return state


def row_of(state: Any, name: str) -> int | None:
    """The row of memory that holds a field of the state, by the name of the field; None if it has none of that name."""
    wanted = getattr(state, name, None)
    arrays = [leaf for leaf in _leaves(state) if not isinstance(leaf, int)]
    return next((row for row, array in enumerate(arrays) if array is wanted), None)


def named_rows(state: Any) -> list[tuple[str, str, Any]]:
    """The rows of memory as (name of the field, what its class says of it, what it holds), in their order."""
    found: list[tuple[str, str, Any]] = []
    if isinstance(state, tuple):
        said = _said_of_fields(type(state))
        for name, part in zip(getattr(state, "_fields", range(len(state))), state, strict=True):
            if isinstance(part, tuple):
                found += named_rows(part)
            elif part is not None and not isinstance(part, int):
                found.append((str(name), said.get(str(name), ""), part))
    return found


def _said_of_fields(kind: type) -> dict[str, str]:
    """What a named tuple's docstring says of each field, under ``Attributes:``, without the shape."""
    said: dict[str, str] = {}
    name = ""
    for line in (inspect.getdoc(kind) or "").partition("Attributes:")[2].split("\n")[1:]:
        begun = re.match(r" {4}(\w+): (.*)", line)
        if begun:
            name = begun[1]
            said[name] = begun[2]
        elif name and line.startswith("     "):
            said[name] += f" {line.strip()}"
        elif line.strip():
            break
    return {name: re.sub(r"(, |; each )?\(batch, nv\)", "", text) for name, text in said.items()}
