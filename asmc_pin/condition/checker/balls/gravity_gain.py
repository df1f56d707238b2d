"""Whether gravity at rest can make a frozen plain loop unstable: small gain, in ball arithmetic (docs/stability.md)."""

from __future__ import annotations

from collections.abc import Sequence

from flint import arb, arb_mat, ctx

from asmc_pin.condition.checker.balls.ball_geometry import cross
from asmc_pin.condition.checker.balls.balls import PRECISIONS, BallArm, positive, upward
from asmc_pin.condition.checker.balls.velocity_forces import largest_eigenvalue, length, slide, way_to
from asmc_pin.condition.checker.reading.certificate_schema import LoopContents, Pieces


def stiffness_in_balls(
    arm: BallArm, lower: Sequence[float], upper: Sequence[float], mbar: Sequence[float], magnitude: float
) -> float:
    """A bound of ‖M̄^(−½) ∂g/∂q M̄^(−½)‖ over a joint box, for gravity of that magnitude and any direction, 1/s²."""
    with ctx.workprec(PRECISIONS[0]):
        bodies = arm.bodies
        n = len(bodies)
        moment = [arb(0)] * n
        for b, body in enumerate(bodies):
            mass = abs(body.mass)
            reach, after = arb(0), -1
            for k in way_to(bodies, b):
                axis = bodies[k].axis
                if bodies[k].slides:
                    moment[k] += mass
                elif k == b:
                    moment[k] += length(cross(axis, body.moment))
                else:
                    away = length(cross(axis, bodies[after].place)) + slide(bodies, after, lower, upper)
                    moment[k] += mass * (away + reach) + length(body.moment)
                if k != b:
                    reach += length(bodies[after].place) + slide(bodies, after, lower, upper)
                after = k
        root = [arb(m).sqrt() for m in mbar]
        scaled = [[arb(0)] * n for _ in range(n)]
        for k in range(n):
            for j in way_to(bodies, k):
                if not bodies[j].slides:
                    scaled[j][k] = scaled[k][j] = arb(magnitude) * moment[k] / (root[j] * root[k])
        return upward(largest_eigenvalue(scaled))


def small_gain_holds(told: LoopContents, pieces: Pieces, stiffness: float) -> bool:
    """Whether the forms of the file prove it for every eigenvalue of M⁻¹M̄ from the first to the last end of the pieces.

    Args:
        told: The header: gains and period.
        pieces: Its forms.
        stiffness: A bound of what gravity's spring is against M̄, 1/s².
    """
    with ctx.workprec(PRECISIONS[0]):
        length_, k, b = arb(told.period), arb(told.ks), arb(told.beta)
        spring = arb(stiffness) * length_**2
        left = 1 - spring * arb(pieces.ends[-1]) / 2
        if not (spring > 0 and left > 0):
            return False
        square_gain = (left / spring) ** 2
        damping, square = (k + b) * length_, k * b * length_**2
        for first, last, row in zip(pieces.ends, pieces.ends[1:], pieces.forms, strict=False):
            xx, xy, xz, yy, yz, zz = (arb(x) for x in row)
            form = arb_mat([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            if positive(3, lambda i, j, p=form: p[i, j]) != "true":  # type: ignore[misc]
                return False
            for a in (first, last):
                change = _change(form, arb(a), damping, square, square_gain)
                if positive(5, lambda i, j, m=change: -m[i, j]) != "true":  # type: ignore[misc]
                    return False
    return True


def _change(form: arb_mat, a: arb, damping: arb, square: arb, square_gain: arb) -> arb_mat:
    """(zᵀPz after a period less before it) + ∫ξ² − gain² ∫w², of z = (ξ, Lξ̇, L²(ū − q̈̂)) and of ∫(1−t)w, ∫w; 5 × 5."""
    command = [-square, -damping, arb(1)]
    step = [
        [1 + a / 2 * command[0], 1 + a / 2 * command[1], a / 2 * command[2], a, arb(0)],
        [a * command[0], 1 + a * command[1], a * command[2], arb(0), a],
        [(1 - a) * command[0], (1 - a) * command[1], (1 - a) * command[2], arb(0), -a],
    ]
    motion = [[arb(1), arb(0), arb(0)], [arb(0), arb(1), arb(0)], [a * c for c in command]]
    span = [[arb(1) / x for x in row] for row in ((1, 2, 6), (2, 3, 8), (6, 8, 20))]
    after, within, gram = arb_mat(step), arb_mat(motion), arb_mat(span)
    found = after.transpose() * form * after
    inside = within.transpose() * gram * within
    for i in range(3):
        for j in range(3):
            found[i, j] += inside[i, j] - form[i, j]
    # The inverse of [[1/3, 1/2], [1/2, 1]].
    for (i, j), entry in {(3, 3): 12, (3, 4): -6, (4, 3): -6, (4, 4): 4}.items():
        found[i, j] -= entry * square_gain
    return found
