"""Within what a number may be, in code and in words."""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.errors import ParameterError

NUMBER = {"type": "number"}
"""A number, as JSON Schema."""


class NumberBound:
    """Bounds of a number, and how they are said.

    Attributes:
        text: What a number must be, with its unit.
        words: The same to follow another phrase, without the unit.
    """

    def __init__(
        self,
        unit: str,
        above: float | None,
        at_least: float | None,
        below: float | None = None,
        at_most: float | None = None,
        infinite: bool = False,
    ) -> None:
        self.above = above
        self.at_least = at_least
        self.below = below
        self.at_most = at_most
        self.infinite = infinite
        named = (("above", above), ("at least", at_least), ("below", below), ("at most", at_most))
        bounds = [f"{word} {x:g}" for word, x in named if x is not None]
        self.text = f"{' and '.join(bounds) or 'finite'} {unit}".strip() + (", or inf" if infinite else "")
        self.words = "".join(f", {bound}" for bound in bounds) + (", or inf" if infinite else "")

    def ok(self, values: Array) -> BoolArray:
        """Which of the values are within it."""
        inside = np.isfinite(values) | (self.infinite & (values == np.inf))
        inside &= values > (-np.inf if self.above is None else self.above)
        inside &= values >= (-np.inf if self.at_least is None else self.at_least)
        if self.below is not None:
            inside &= values < self.below
        inside &= values <= (np.inf if self.at_most is None else self.at_most)
        return np.asarray(inside)


def as_floats(name: str, value: object, expected: str) -> Array:
    """A float64 copy; numbers only, so that a stray string or boolean is not taken for one."""
    try:
        given = np.asarray(value)
    except ValueError:  # ragged nesting
        given = np.asarray(None)
    if given.dtype.kind not in "iuf" or (given.ndim > 0 and given.size == 0):
        raise ParameterError(name, f"got {value!r}; expected {expected}")
    return np.array(given, dtype=np.float64, order="C")
