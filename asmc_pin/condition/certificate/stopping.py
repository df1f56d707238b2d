"""Why a proof stopped. Each sentence is said only where it is the cause."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.compiled.bisection_tree import DEEPEST
from asmc_pin.condition.certificate.statement import Statement
from asmc_pin.condition.certificate.statement_forms import MARGIN
from asmc_pin.condition.certificate.walk import Status

GAP_MET = "the gap is met"
OUT_OF_TIME = "out of time"
INTERRUPTED = "interrupted"
NO_MULTIPLE = "no positive multiple of M̄ satisfies Lemma 1"
NORM_REFUTED = "a configuration was found whose norm is not below the level"
LEVEL_PROVEN = "the level asked for is proven"
SHARE_SPENT = "its share of the time was spent"
TOO_SLOW = "it would not have ended in time"
FREED = (
    "joints that mimic others: proven as if each moved freely and bore a share of its m̄, which is sufficient and may "
    "fall short of what holds"
)
SHARES = (
    "joints that mimic others are proven as if each moved freely and bore a share of its m̄, which is more than has to "
    "hold, and does not"
)
CORNERS = (
    "a range of the payload's place is proven by its corners, with less inertia there than any place between has, "
    "which is more than has to hold, and does not; ask for parts of the range"
)

NEAREST = 4.0 * MARGIN
"""What is tried within this share of what is refuted cannot be told from it: a proof is of a little more than is said,
and a counter-example of a little less."""


@dataclass(frozen=True, eq=False)
class Obstacle:
    """Where a proof did not get on, and the search that went on from there found no counter-example.

    Attributes:
        status: Of the walk: ``refuted``, ``narrow`` or ``rounding``.
        statement: What was to be proven.
        q: Where, shape (nv,), rad (m where prismatic).
    """

    status: Status
    statement: Statement
    q: Array

    def reason(self, near: bool) -> str:
        """The cause, in words.

        Args:
            near: Whether what was tried is within `NEAREST` of what is refuted.
        """
        if near:
            return f"what was to be proven next is within {NEAREST:g} of what is refuted, too near to be told from it"
        where = f"near q = ({', '.join(f'{value:.4g}' for value in self.q)})"
        if self.statement.kind == "level" and np.any(self.statement.slack > 0.0):
            return (
                f"{where} one bound for all ends of the armature's range, which have too many corners to be proven one "
                "by one, is too weak"
            )
        if self.status == "narrow":
            return f"{where} a cell that was halved {DEEPEST} times is not proven, and none is made narrower"
        return f"{where} the condition holds by less than is allowed for rounding"
