"""One trial as a law's source speaks of it, and what became of a claim there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from asmc_pin._typing import Array, BoolArray


@dataclass(frozen=True, eq=False)
class History:
    """One trial tick by tick, of the true motion; arrays of shape (T, nv), NaN after a divergence.

    Attributes:
        time: Shape (T,), s.
        error: e = q_d − q, rad.
        rate: ė, rad/s.
        bend: q̈_d less the mean of q̈ over the period that begins, rad/s²; NaN at the last tick.
        s: Sliding variable (4), rad/s.
        gain: k̂, rad/s²; NaN without one.
    """

    time: Array
    error: Array
    rate: Array
    bend: Array
    s: Array
    gain: Array


@dataclass(frozen=True, eq=False)
class Findings:
    """What became of a claim of the form "excess ≤ 0 wherever checked".

    Attributes:
        excess: Largest over the joints, shape (T,), in the claim's unit; above 0 where it is broken.
        checked: Where the claim speaks of a joint at least, shape (T,), bool.
        push: What drives the joints besides the law, shape (T, nv), rad/s²; or how fast that changes.
        of_rate: Whether it is the latter, rad/s³.
        seen: What was seen.
        untested: What to say where there is nothing to check.
    """

    excess: Array
    checked: BoolArray
    push: Array
    seen: str
    untested: str
    of_rate: bool = False


class Promise(Protocol):
    """A claim of a law's source, with the law's own figures in it.

    Attributes:
        levers: The law's parameters that decide whether it holds, which a monitor may try other values of.
    """

    levers: ClassVar[tuple[str, ...]]

    def findings(self, history: History) -> Findings:
        """What became of it in a trial."""
        ...


def once(entered: BoolArray) -> BoolArray:
    """Where something has been so at this tick or before, shape (T, nv)."""
    return np.asarray(np.logical_or.accumulate(entered, axis=0))


def gathered(over: Array, checked: BoolArray, push: Array, seen: str, untested: str, of_rate: bool = False) -> Findings:
    """Findings from what each joint has, `over` and `checked` of shape (T, nv)."""
    known = checked & np.isfinite(over)
    excess = np.where(known, over, -np.inf).max(axis=1)
    return Findings(np.asarray(excess), np.asarray(known.any(axis=1)), push, seen, untested, of_rate)
