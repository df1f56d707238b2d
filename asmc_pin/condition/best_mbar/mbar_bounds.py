"""Bounds on M̄ as they are given, read and checked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from asmc_pin.condition.best_mbar.convex_program import Bounds, Form
from asmc_pin.errors import ParameterError

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

BoundsLike: TypeAlias = "tuple[float | None, float | None] | Mapping[str, tuple[float | None, float | None]] | None"
"""(least, largest) m̄ of every joint, or joint to such a pair; None where there is no bound, kg·m²."""

FARTHEST = 1e6
"""Bounds on m̄ that are taken, kg·m²: with larger ones the program's numbers lie too far apart to be solved."""


def read_bounds(arm: Arm, bounds: BoundsLike, form: Form) -> Bounds:
    """Bounds on each m̄ᵢ, checked."""
    lower, upper = np.zeros(arm.nv), np.full(arm.nv, np.inf)
    given = bounds if isinstance(bounds, Mapping) else dict.fromkeys(arm.joint_names, bounds or (None, None))
    for joint, ends in given.items():
        if joint not in arm.joint_names:
            known = ", ".join(arm.joint_names)
            raise ParameterError("bounds", f"'{joint}' is not a joint of {arm.name}; its joints: {known}")
        try:
            low, high = (
                fallback if end is None else float(end) for end, fallback in zip(ends, (0.0, np.inf), strict=True)
            )
        except (TypeError, ValueError):
            raise ParameterError("bounds", f"{ends!r} given for joint '{joint}', (least, largest) expected") from None
        given_words = f"{low:g}:{high:g} for joint '{joint}'"
        if low < 0.0 < high:
            raise ParameterError("bounds", f"{given_words}: an m̄ is positive; leave the least out where there is none")
        if not (0.0 <= low <= high) or high == 0.0 or np.isinf(low):
            raise ParameterError("bounds", f"{given_words}: no positive m̄ lies between")
        if low > FARTHEST or FARTHEST < high < np.inf:
            raise ParameterError(
                "bounds", f"{given_words}: at most {FARTHEST:g} kg·m² are taken; leave the largest out for no bound"
            )
        lower[arm.joint_names.index(joint)], upper[arm.joint_names.index(joint)] = low, high
    if form == "scalar" and lower.max() > upper.min():
        raise ParameterError("bounds", f"no single m̄ lies between {lower.max():g} and {upper.min():g}")
    return Bounds(lower, upper, form)
