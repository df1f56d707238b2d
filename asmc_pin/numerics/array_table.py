"""Arrays that stay where they are over many compiled calls, handed to each call as one table of addresses and shapes.

numba looks at every array that a compiled function is handed, which for twenty of them takes longer than the tick of a
trial. In compiled code a view of an address costs nothing; as Python it is made with ctypes.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from typing import Any

import numba
import numpy as np
from numba import types
from numba.extending import intrinsic, overload

from asmc_pin._typing import Array, IntArray

AXES = 4
"""Most axes of an array in a table."""

_types: Any = types  # numba has no types
_numba: Any = numba
_carray: Any = _numba.carray
_intrinsic: Any = intrinsic
_overload: Any = overload


class ArrayTable:
    """Arrays by the numbers of their rows; compiled code takes `rows`, and makes views with `floats1` and the others.

    Attributes:
        rows: Address and shape of each array, (arrays, 1 + AXES).
    """

    def __init__(self, arrays: Sequence[Any]) -> None:
        self._arrays: list[Any] = [None] * len(arrays)  # an address keeps nothing alive
        self.rows: IntArray = np.zeros((len(arrays), 1 + AXES), dtype=np.int64)
        for row, array in enumerate(arrays):
            self.put(row, array)

    def put(self, row: int, array: Any) -> None:
        """Have another array in a row; one that is C-ordered, as the views take it for."""
        if not array.flags.c_contiguous:
            raise ValueError(f"array {row} of a table has to be C-ordered")
        self._arrays[row] = array
        self.rows[row] = [array.ctypes.data, *array.shape, *(AXES - array.ndim) * [0]]


def _pointer(typing: Any, address: Any, kind: Any) -> tuple[Any, Callable[..., Any]]:
    """Types and code of `_pointer_to`, for numba."""
    pointer = _types.CPointer(kind.dtype)

    def cast(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.inttoptr(values[0], context.get_value_type(pointer))

    return pointer(address, kind), cast


_pointer_to: Any = _intrinsic(_pointer)


def _seen(table: IntArray, row: int, axes: int, kind: Any) -> Any:
    """The view in Python."""
    address, shape = int(table[row, 0]), tuple(table[row, 1 : 1 + axes].tolist())
    size = int(np.prod(shape)) * np.dtype(kind).itemsize
    if not size:
        return np.empty(shape, kind)
    return np.frombuffer((ctypes.c_char * size).from_address(address), kind).reshape(shape)


def floats1(table: IntArray, row: int) -> Array:
    """A view of floats with one axis."""
    view: Array = _seen(table, row, 1, np.float64)
    return view


def floats2(table: IntArray, row: int) -> Array:
    """A view of floats with two axes."""
    view: Array = _seen(table, row, 2, np.float64)
    return view


def floats3(table: IntArray, row: int) -> Array:
    """A view of floats with three axes."""
    view: Array = _seen(table, row, 3, np.float64)
    return view


def floats4(table: IntArray, row: int) -> Array:
    """A view of floats with four axes."""
    view: Array = _seen(table, row, 4, np.float64)
    return view


def whole1(table: IntArray, row: int) -> IntArray:
    """A view of whole numbers with one axis."""
    view: IntArray = _seen(table, row, 1, np.int64)
    return view


def whole2(table: IntArray, row: int) -> IntArray:
    """A view of whole numbers with two axes."""
    view: IntArray = _seen(table, row, 2, np.int64)
    return view


# In compiled code. A table has its rows checked when it is made; here nothing is.
_overload(floats1, strict=False)(
    lambda table, row: lambda table, row: _carray(_pointer_to(table[row, 0], np.float64), (table[row, 1],))
)
_overload(floats2, strict=False)(
    lambda table, row: (
        lambda table, row: _carray(_pointer_to(table[row, 0], np.float64), (table[row, 1], table[row, 2]))
    )
)
_overload(floats3, strict=False)(
    lambda table, row: (
        lambda table, row: _carray(
            _pointer_to(table[row, 0], np.float64), (table[row, 1], table[row, 2], table[row, 3])
        )
    )
)
_overload(floats4, strict=False)(
    lambda table, row: (
        lambda table, row: _carray(
            _pointer_to(table[row, 0], np.float64), (table[row, 1], table[row, 2], table[row, 3], table[row, 4])
        )
    )
)
_overload(whole1, strict=False)(
    lambda table, row: lambda table, row: _carray(_pointer_to(table[row, 0], np.int64), (table[row, 1],))
)
_overload(whole2, strict=False)(
    lambda table, row: lambda table, row: _carray(_pointer_to(table[row, 0], np.int64), (table[row, 1], table[row, 2]))
)
