"""Points and small boxes inside a statement's cells, put to the condition in ball arithmetic.

The replay of the cells shares a theorem with the prover; this shares nothing. It looks where an error would show: in
the cells in which least is left, and in some drawn at random.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb, ctx

from asmc_pin._typing import Array
from asmc_pin.condition.checker.balls.balls import PRECISIONS, BallArm, holds
from asmc_pin.condition.checker.reading.header_parts import WrittenCase, WrittenStatement

_TRIED = 256
"""Configurations of a cell among which the one with least left is looked for."""

_NOT_SO = {
    "false": "at a configuration of its box it is not so, in balls",
    "open": "at a configuration of its box it could not be decided in balls",
}

_WIDEST = 0.1
_HALVINGS = 16


@dataclass(frozen=True)
class Spots:
    """What was evaluated in ball arithmetic, and whether the condition was so there.

    Attributes:
        points: Configurations.
        boxes: Small boxes.
        widths: Least and largest half width of those, rad (m where prismatic); None without any.
        problem: A sentence where the condition is not so somewhere; else empty.
    """

    points: int = 0
    boxes: int = 0
    widths: tuple[float, float] | None = None
    problem: str = ""


def spot_checks(
    arm: BallArm,
    least: Callable[[Array], Array],
    statement: WrittenStatement,
    case: WrittenCase,
    mbar: Sequence[float],
    centres: Array,
    halves: Array,
    seed: int,
    drawn: int,
) -> Spots:
    """Evaluate a statement at one point and in one small box of each of some cells.

    Args:
        arm: The arm.
        least: How little is left of it at configurations (k, nv), in floating point, shape (k,): it only guides.
        statement: The statement.
        case: Its case.
        mbar: M̄.
        centres: Of the cells, shape (k, n).
        halves: Their half widths, shape (k, n).
        seed: Of the points.
        drawn: How many configurations of the whole box to try besides, wherever they fall.

    Returns:
        How many were evaluated, and what was found wrong.
    """
    rng = np.random.default_rng(seed)
    points = 0
    widths: list[float] = []
    lower, upper = np.array(case.lower), np.array(case.upper)
    # Wherever they fall: the places that floating point chooses are no test of floating point.
    for share in rng.random((drawn, lower.size)):
        q = np.clip(lower + share * (upper - lower), lower, upper)
        verdict = _asked(arm, statement, mbar, q, np.zeros_like(q), _armature(statement, case, rng))
        if verdict != "true":
            return Spots(points, 0, None, _NOT_SO[verdict])
        points += 1
    for centre, half in zip(centres, halves, strict=True):
        q = centre + half * rng.uniform(-1.0, 1.0, (_TRIED, centre.size))
        q = np.clip(np.concatenate((centre[None], q)), case.lower, case.upper)
        q = q[np.argmin(least(q))]
        armature = _armature(statement, case, rng)
        verdict = _asked(arm, statement, mbar, q, np.zeros_like(q), armature)
        if verdict != "true":
            return Spots(points, len(widths), _range(widths), _NOT_SO[verdict])
        points += 1
        radius = np.minimum(half, _WIDEST)
        for _ in range(_HALVINGS):
            if not radius.any():
                break
            # A box inside the cell, around the place where least is left.
            middle = np.clip(q, centre - half + radius, centre + half - radius)
            verdict = _asked(arm, statement, mbar, middle, radius, armature, PRECISIONS[:1])
            if verdict == "false":
                return Spots(points, len(widths), _range(widths), "in a part of its box it is not so, in balls")
            if verdict == "true":
                widths.append(float(radius.max()))
                break
            radius = 0.5 * radius
    return Spots(points, len(widths), _range(widths))


def _asked(
    arm: BallArm,
    statement: WrittenStatement,
    mbar: Sequence[float],
    q: Array,
    radius: Array,
    armature: Sequence[float],
    precisions: Sequence[int] = PRECISIONS,
) -> str:
    verdict = "open"
    for bits in precisions:
        with ctx.workprec(bits):
            angles = [arb(float(x), float(r)) for x, r in zip(q, radius, strict=True)]
            verdict = holds(statement, arm.mass_matrix(angles, [arb(a) for a in armature]), mbar)
        if verdict != "open":
            break
    return verdict


def _armature(statement: WrittenStatement, case: WrittenCase, rng: np.random.Generator) -> list[float]:
    """One out of the range that the statement is used for: of a level its own, else the case's; an end or between."""
    low, high = np.array(case.armature_lower), np.array(case.armature_upper)
    if statement.kind == "level":
        low = np.array(statement.armature)
        high = low + np.array(statement.slack)
    share = rng.choice([0.0, 1.0, float(rng.random())])
    return [float(x) for x in np.clip(low + share * (high - low), low, high)]


def _range(widths: Sequence[float]) -> tuple[float, float] | None:
    return (min(widths), max(widths)) if widths else None
