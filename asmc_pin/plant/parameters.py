"""Reading what a user gave for joints and trials."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError


def read_only(name: str, value: ArrayLike) -> Array:
    """A read-only float64 copy of a scalar, (nv,) or (batch, nv) parameter.

    Raises:
        ParameterError: not numbers, or more than two axes.
    """
    try:
        array = np.array(value, dtype=np.float64, order="C")
    except (TypeError, ValueError):
        raise ParameterError(name, f"{value!r} given; expected a number, or one per joint") from None
    if array.ndim > 2:
        raise ParameterError(name, f"shape {array.shape} given; expected a scalar, (nv,) or (batch, nv)")
    array.setflags(write=False)
    return array


def per_trial(name: str, value: ArrayLike, batch: int, nv: int) -> Array:
    """The parameter spread to (batch, nv): a new C-ordered array that may be written to.

    Raises:
        ParameterError: it is for another number of joints or trials.
    """
    array = read_only(name, value)
    if array.ndim and array.shape[-1] != nv:
        raise ParameterError(
            name, f"{array.shape[-1]} values per trial given for {nv} joints; give {nv}, or one number for all"
        )
    if array.ndim == 2 and array.shape[0] != batch:
        raise ParameterError(
            name,
            f"given for {array.shape[0]} trials, but the batch has {batch}; "
            f"give {batch} rows, or one value per joint for all",
        )
    return np.broadcast_to(array, (batch, nv)).copy()
