"""What the statements of a certificate prove about the eigenvalues of M against those of W = diag(mbar), exactly."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from asmc_pin.condition.checker.conclusions import covers_above, covers_below
from asmc_pin.condition.checker.reading.header_parts import Header, WrittenStatement


@dataclass(frozen=True)
class Spectrum:
    """Bounds over every case, q and armature of the file.

    Attributes:
        above: M ≻ this times W; None where no such statement covers every case.
        below: M ≺ this times W; likewise.
    """

    above: Fraction | None
    below: Fraction | None


@dataclass(frozen=True)
class EndsSeen:
    """What the two configurations of a file show.

    Attributes:
        least: W^(−½) M W^(−½) has an eigenvalue of at most this at the first.
        largest: And one of at least this at the second.
    """

    least: float
    largest: float


def spectrum(told: Header) -> Spectrum:
    """The bounds that follow, if all statements are true."""
    return Spectrum(
        _over_all(told, "weighted", covers_below, lambda s: Fraction(s.scale) / (1 + Fraction(s.level)), max, min),
        _over_all(told, "bounded", covers_above, lambda s: Fraction(s.scale) / (1 - Fraction(s.level)), min, max),
    )


def float_below(number: Fraction) -> float:
    """The largest float that is not above a number of at least zero."""
    value = _nearest(number)
    return value if value < math.inf and Fraction(value) <= number else math.nextafter(value, -math.inf)


def float_above(number: Fraction) -> float:
    """The least float that is not below a number of at least zero."""
    value = _nearest(number)
    return value if value == math.inf or Fraction(value) >= number else math.nextafter(value, math.inf)


def _nearest(number: Fraction) -> float:
    try:
        return float(number)
    except OverflowError:
        return math.inf


def _over_all(
    told: Header,
    kind: str,
    covers: Callable[..., bool],
    bound: Callable[[WrittenStatement], Fraction],
    best: Callable[..., Fraction],
    worst: Callable[..., Fraction],
) -> Fraction | None:
    """The best bound of each case, and of these the worst; None where a case has none."""
    by_case: dict[int, list[Fraction]] = {}
    for statement in told.statements:
        if statement.kind == kind and covers(statement, told.cases[statement.case]):
            by_case.setdefault(statement.case, []).append(bound(statement))
    if len(by_case) < len(told.cases):
        return None
    return worst(best(found) for found in by_case.values())
