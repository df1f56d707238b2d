"""Joint vectors with leading axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError


def joint_rows(joint_names: Sequence[str], arguments: Mapping[str, Array]) -> tuple[tuple[int, ...], list[Array]]:
    """Check joint vectors, broadcast their leading axes and lay them out as rows.

    Args:
        joint_names: One per joint, for messages.
        arguments: Arrays of shape (..., nv) by the name the caller knows them by.

    Returns:
        The common leading shape, and per argument an array of shape (rows, nv).

    Raises:
        ParameterError: Not numbers, a last axis that is not nv long, or leading axes that do not broadcast.
    """
    nv = len(joint_names)
    arrays = {}
    for name, value in arguments.items():
        try:
            array = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError):
            raise ParameterError(name, f"{value!r} given, numbers expected") from None
        if array.ndim == 0 or array.shape[-1] != nv:
            expected = f"(..., {nv}) expected: one value per joint ({', '.join(joint_names)})"
            raise ParameterError(name, f"shape {array.shape} given, {expected}")
        arrays[name] = array
    try:
        lead = np.broadcast_shapes(*(array.shape[:-1] for array in arrays.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
        raise ParameterError(", ".join(arrays), f"their leading axes do not broadcast: {shapes}") from None
    return lead, [np.broadcast_to(array, (*lead, nv)).reshape(-1, nv) for array in arrays.values()]
