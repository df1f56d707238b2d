"""A law's state as rows of numbers, and back: a named tuple of arrays outside, memory of one trial in compiled code."""

from __future__ import annotations

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
