"""The two configurations of a certificate that show how bad it gets, put to the condition in ball arithmetic."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from flint import arb, arb_mat, ctx

from asmc_pin._typing import Array
from asmc_pin.condition.checker.balls.balls import PRECISIONS, BallArm, downward, no_multiple, norm_bound
from asmc_pin.condition.checker.conclusions import Witness
from asmc_pin.condition.checker.reading.certificate_schema import Contents
from asmc_pin.condition.checker.reading.header_parts import Header, Malformed, Seen
from asmc_pin.condition.checker.reading.link_chain import Chain

_NEAR = 1e-9


def witness(told: Contents, arms: Sequence[BallArm], chains: Sequence[Chain]) -> Witness:
    """Evaluate the worst configuration and the counter-example of a certificate.

    Args:
        told: The header.
        arms: One per case.
        chains: One per case.

    Returns:
        What they show.

    Raises:
        Malformed: One of them lies outside its joint box or the armature's range.
    """
    worst, refuted = (inside(told, seen, chains[seen.case]) for seen in (told.worst, told.refuted))
    with ctx.workprec(PRECISIONS[0]):
        mass = mass_at(arms[told.worst.case], *worst)
        norm = norm_bound(told.condition, 1.0, mass, told.mbar, _direction(told, 1.0, mass))
        lower = 0.0 if norm is None else max(0.0, downward(norm))
        at_level = norm is not None and bool(norm >= told.level)
        mass = mass_at(arms[told.refuted.case], *refuted)
        scale = told.scale_refuted
        if scale > 0.0:
            norm = norm_bound(told.condition, scale, mass, told.mbar, _direction(told, scale, mass))
            broken = norm is not None and bool(norm >= 1)
        else:
            broken = told.condition == "lemma1" and no_multiple(mass, told.mbar, _least(told, mass))
    return Witness(lower, at_level, broken)


def mass_at(arm: BallArm, q: Sequence[float], armature: Sequence[float]) -> arb_mat:
    """The inertia matrix at one configuration."""
    return arm.mass_matrix([arb(x) for x in q], [arb(a) for a in armature])


def inside(told: Header, seen: Seen, chain: Chain) -> tuple[list[float], list[float]]:
    """The configuration and its armature, put into their ranges where they lie outside by no more than a rounding.

    Raises:
        Malformed: They lie outside by more.
    """
    case = told.cases[seen.case]
    found: list[list[float]] = []
    # Joints that carry the whole arm do not matter.
    free = [bool(matters) for matters in chain.matters]
    for values, lower, upper, matters in (
        (seen.q, case.lower, case.upper, free),
        (seen.armature, case.armature_lower, case.armature_upper, [True] * len(free)),
    ):
        row = [min(max(x, lo), hi) for x, lo, hi in zip(values, lower, upper, strict=True)]
        if any(m and abs(x - y) > _NEAR for m, x, y in zip(matters, row, values, strict=True)):
            raise Malformed("a configuration that it shows lies outside the joint box or the armature's range")
        found.append(row)
    return found[0], found[1]


def _direction(told: Contents, scale: float, mass: arb_mat) -> list[float]:
    """The direction in which the norm is attained, nearly."""
    M, m = centres_of(mass), scale * np.array(told.mbar)
    if told.condition == "weighted":
        root = np.sqrt(m)
        values, vectors = np.linalg.eigh(np.eye(m.size) - root[:, None] * np.linalg.inv(M) * root)
        return [float(x) for x in vectors[:, np.argmax(np.abs(values))]]
    return [float(x) for x in np.linalg.svd(np.eye(m.size) - np.linalg.inv(M) * m)[2][0]]


def _least(told: Contents, mass: arb_mat) -> list[float]:
    """The direction u of least uᵀ M⁻¹M̄ u, nearly."""
    A = np.linalg.inv(centres_of(mass)) * np.array(told.mbar)
    return [float(x) for x in np.linalg.eigh(A + A.T)[1][:, 0]]


def centres_of(mass: arb_mat) -> Array:
    """A matrix of balls as floats near it, for guesses."""
    n = mass.nrows()
    return np.array([[float(mass[i, j].mid()) for j in range(n)] for i in range(n)])
