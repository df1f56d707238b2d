"""The two configurations of a certificate about eigenvalues, evaluated in ball arithmetic."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from flint import arb, ctx

from asmc_pin.condition.checker.balls.balls import PRECISIONS, BallArm, downward, upward
from asmc_pin.condition.checker.balls.witness import centres_of, inside, mass_at
from asmc_pin.condition.checker.reading.header_parts import Header, Malformed, Seen
from asmc_pin.condition.checker.reading.link_chain import Chain
from asmc_pin.condition.checker.spectrum import EndsSeen


def eigenvalues_seen(
    told: Header, weights: Sequence[arb], arms: Sequence[BallArm], chains: Sequence[Chain]
) -> EndsSeen:
    """What they show of the eigenvalues of M against W: a Rayleigh quotient lies between the least and the largest.

    Args:
        told: The header.
        weights: Diagonal of W, positive.
        arms: One per case.
        chains: One per case.

    Raises:
        Malformed: One of them lies outside its joint box or the armature's range, or cannot be evaluated.
    """
    first, last = told.seen
    least = _quotient(told, first, weights, arms, chains, 0)
    largest = _quotient(told, last, weights, arms, chains, -1)
    found = EndsSeen(upward(least), downward(largest))
    if not (0.0 < found.least < np.inf and 0.0 < found.largest < np.inf):
        raise Malformed("the eigenvalues at the configurations that it shows cannot be evaluated")
    return found


def _quotient(
    told: Header, seen: Seen, weights: Sequence[arb], arms: Sequence[BallArm], chains: Sequence[Chain], which: int
) -> arb:
    with ctx.workprec(PRECISIONS[0]):
        mass = mass_at(arms[seen.case], *inside(told, seen, chains[seen.case]))
        root = np.sqrt([float(w.mid()) for w in weights])
        # Any direction makes it true, a good one close.
        vectors = np.linalg.eigh(centres_of(mass) / root / root[:, None])[1]
        u = [arb(float(x)) for x in vectors[:, which] / root]
        n = len(u)
        top = sum((u[i] * mass[i, j] * u[j] for i in range(n) for j in range(n)), arb(0))
        return top / sum((w * x * x for w, x in zip(weights, u, strict=True)), arb(0))
