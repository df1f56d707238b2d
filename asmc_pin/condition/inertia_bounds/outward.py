"""Exact products of floats, rounded to the side on which they stay true."""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction


def below(number: Fraction) -> float:
    """The largest float that is not above a positive number."""
    value = float(number)
    return value if Fraction(value) <= number else math.nextafter(value, -math.inf)


def above(number: Fraction) -> float:
    """The least float that is not below a positive number."""
    value = float(number)
    return value if Fraction(value) >= number else math.nextafter(value, math.inf)


def products(weights: Iterable[float], scaling: Iterable[float]) -> list[Fraction]:
    """W S² exactly, joint by joint: with m W ≺ M it is m times the least of them that S M S is above."""
    return [Fraction(w) * Fraction(s) ** 2 for w, s in zip(weights, scaling, strict=True)]
