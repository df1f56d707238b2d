"""The bound of the velocity forces in ball arithmetic, from the URDF's decimals; the proof is in docs/bounds.md."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from flint import arb, arb_mat, ctx

from asmc_pin._typing import Array
from asmc_pin.condition.checker.balls.ball_geometry import cross, dot, unit, zero
from asmc_pin.condition.checker.balls.balls import PRECISIONS, BallArm, Body, positive, upward
from asmc_pin.condition.checker.reading.header_parts import Malformed

_TRIED = 40


def velocity_forces_in_balls(
    arm: BallArm, lower: Sequence[float], upper: Sequence[float], scaling: Sequence[float], largest: float | None
) -> float:
    """A c with ‖S C(q, Sx) Sx‖ ≤ c ‖x‖² over a joint box.

    Args:
        arm: The arm.
        lower: Joint box.
        upper: The same.
        scaling: Diagonal of S.
        largest: A bound of the eigenvalues of S M S over the box, or None.

    Raises:
        Malformed: A body has a mass or moments that cannot be told to be those of any mass.
    """
    with ctx.workprec(PRECISIONS[0]):
        bodies = arm.bodies
        n = len(bodies)
        s = [arb(x) for x in scaling]
        way = [way_to(bodies, k) for k in range(n)]
        size = [[arb(0)] * n for _ in range(n)]  # of ∫|∂p/∂q_k|² dm over what lies beyond t, [k][t]
        lack = [arb(0)] * n
        for b in range(n):
            share, lack[b] = _shares(bodies, b, way[b], lower, upper)
            for t in way[b]:
                for k in way[t]:
                    size[k][t] += share[k]
        if largest is not None:
            for k in range(n):
                beyond = sum((lack[b] for b in range(n) if k in way[b]), arb(0))
                most = arb(largest) / s[k] ** 2 + 6 * beyond
                size[k] = [_less(x, most) for x in size[k]]
        root = [[s[k] * size[k][t].sqrt() for t in range(n)] for k in range(n)]
        found = upward(_by_components(bodies, way, root, s))
        if largest is not None:
            energy = arb(largest) + 6 * n * sum(lack, arb(0)) * arb(max(scaling)) ** 2
            found = min(found, upward(energy.sqrt() * _of_accelerations(bodies, way, root, s)))
    return found


def way_to(bodies: Sequence[Body], k: int) -> list[int]:
    """Joint k and those on the way to it, from it to the base."""
    found = []
    while k >= 0:
        found.append(k)
        k = bodies[k].parent
    return found


def _shares(
    bodies: Sequence[Body], b: int, way: Sequence[int], lower: Sequence[float], upper: Sequence[float]
) -> tuple[dict[int, arb], arb]:
    """Of body b, a bound of ∫|∂p/∂q_k|² dm for each k on the way to it, and what its second moments lack."""
    body = bodies[b]
    if body.mass > 0:
        centre = body.moment * (1 / body.mass)
    elif body.mass == 0 and all(x == 0 for x in body.moment.entries()):
        centre = zero()
    else:
        raise Malformed("a body of the arm has a mass that is not positive")
    about = body.tensor - (unit() * dot(centre, centre) - centre * centre.transpose()) * body.mass
    spread = (about[0, 0] + about[1, 1] + about[2, 2]) / 2
    moments = unit() * spread - about
    lack = _lack(moments, spread)
    reach, after = dot(centre, centre).sqrt(), -1
    share = {}
    for k in way:
        axis = bodies[k].axis
        if bodies[k].slides:
            share[k] = body.mass
        elif k == b:
            lever = cross(axis, centre)
            share[k] = body.mass * dot(lever, lever) + dot(axis, about * axis)
        else:
            place = bodies[after].place
            share[k] = body.mass * (length(cross(axis, place)) + slide(bodies, after, lower, upper) + reach) ** 2
            share[k] += spread
        share[k] += 6 * lack
        if k != b:
            reach += length(bodies[after].place) + slide(bodies, after, lower, upper)
        after = k
    return share, lack


def _lack(moments: arb_mat, spread: arb) -> arb:
    """A δ with which the second moments plus δ are positive definite, for sure."""
    centre = np.array([[float(moments[i, j].mid()) for j in range(3)] for i in range(3)])
    if not np.all(np.isfinite(centre)):
        raise Malformed("a body of the arm has second moments that are no numbers")
    least = float(np.linalg.eigvalsh(0.5 * (centre + centre.T))[0])
    tried = max(0.0, -least) + 1e-12 * abs(float(spread.mid())) + 1e-25
    for _ in range(_TRIED):
        delta = arb(tried)
        if positive(3, lambda i, j, d=delta: moments[i, j] + (d if i == j else 0)) == "true":  # type: ignore[misc]
            return delta
        tried *= 10.0
    raise Malformed("a body of the arm has second moments that cannot be evaluated")


def slide(bodies: Sequence[Body], k: int, lower: Sequence[float], upper: Sequence[float]) -> arb:
    """How far joint k slides from its origin at most; 0 where it turns."""
    return arb(max(abs(lower[k]), abs(upper[k]))) if bodies[k].slides else arb(0)


def length(vector: arb_mat) -> arb:
    """At least the length of a vector."""
    # The square of a vector that may be zero is a ball around it, and a ball has no root below zero.
    return arb(upward(abs(dot(vector, vector)))).sqrt()


def _less(a: arb, b: arb) -> arb:
    """The smaller of two bounds: both are true."""
    return a if upward(a) <= upward(b) else b


def _by_components(
    bodies: Sequence[Body], way: Sequence[Sequence[int]], root: Sequence[Sequence[arb]], s: Sequence[arb]
) -> arb:
    """By bounds of each Christoffel symbol, as a matrix with a row for each force and a column for each pair (j, k)."""
    n = len(bodies)
    rows: list[dict[tuple[int, int], arb]] = [{} for _ in range(n)]
    for k in range(n):
        for j in way[k]:
            for i in range(n):
                if not bodies[j].slides and i != k and (i in way[k] or k in way[i]):
                    top = k if i in way[k] else i
                    rows[i][j, k] = root[i][top] * root[k][top] * s[j]

    def product(a: dict[tuple[int, int], arb], b: dict[tuple[int, int], arb]) -> arb:
        # Every pair of two different joints stands for itself and its mirror image.
        return sum((x * b[jk] * (1 if jk[0] == jk[1] else 2) for jk, x in a.items() if jk in b), arb(0))

    return largest_eigenvalue([[product(a, b) for b in rows] for a in rows]).sqrt()


def _of_accelerations(
    bodies: Sequence[Body], way: Sequence[Sequence[int]], root: Sequence[Sequence[arb]], s: Sequence[arb]
) -> arb:
    """Largest root of ∫|a|² dm of the accelerations a of the mass at unit velocities."""
    n = len(bodies)
    matrix = [[arb(0)] * n for _ in range(n)]
    for k in range(n):
        for j in way[k]:
            if not bodies[j].slides:
                matrix[j][k] = matrix[k][j] = s[j] * root[k][k]
    return largest_eigenvalue(matrix)


def largest_eigenvalue(matrix: Sequence[Sequence[arb]]) -> arb:
    """At least the largest eigenvalue of a symmetric A without negative entries, and close to it."""
    guess = np.array([[float(x.mid()) for x in row] for row in matrix])
    v = np.ones(len(guess))
    if np.all(np.isfinite(guess)):
        for _ in range(100):
            v = guess @ v + 1e-9 * v.max()
            v = v / v.max() if v.max() > 0.0 else np.ones(len(guess))
    return eigenvalue_bound(matrix, np.where(np.isfinite(v) & (v > 0.0), v, 1.0))


def eigenvalue_bound(matrix: Sequence[Sequence[arb]], v: Array) -> arb:
    """The largest eigenvalue of a symmetric A without negative entries is at most max (A v)_i / v_i, for any v > 0."""
    ratios = [
        sum((x * arb(float(y)) for x, y in zip(row, v, strict=True)), arb(0)) / arb(float(v[i]))
        for i, row in enumerate(matrix)
    ]
    worst = max((upward(ratio) for ratio in ratios), default=0.0)
    return arb(worst) if math.isfinite(worst) else arb("inf")
