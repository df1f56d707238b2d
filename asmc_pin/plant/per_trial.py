"""Reading what a user gave for joints and trials."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError
from asmc_pin.parameters import PerJoint, parameters_of


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


def sized(table: str, instance: object, nv: int) -> None:
    """Check that each `PerJoint` field of a dataclass is a scalar or has nv values.

    Raises:
        ParameterError: names the field, ``table.field``.
    """
    for name, item in parameters_of(type(instance)).items():
        value = getattr(instance, name)
        if isinstance(item, PerJoint) and value is not None:
            per_trial(f"{table}.{name}", value, 1, nv)


def row(value: ArrayLike | None, nv: int, absent: float) -> Array:
    """A checked per-joint parameter as a new array of shape (nv,); `absent` where it is None."""
    return np.array(np.broadcast_to(np.float64(absent) if value is None else np.asarray(value), (nv,)))
