"""One box of joint cells: is the condition proven in it, refuted at its centre, or which joint loses most?"""

from __future__ import annotations

import numpy as np
from numba import njit

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.compiled.cell_loss import WHOLE, loss, mean_of_turn
from asmc_pin.condition.certificate.compiled.first_joints import positive_over_range
from asmc_pin.condition.certificate.compiled.inward_pass import base, eliminate_joint, inward, start
from asmc_pin.condition.certificate.compiled.joint_steps import GUARD, shift_onto, slide, spread, turn
from asmc_pin.condition.certificate.compiled.outward_pass import outward
from asmc_pin.condition.certificate.compiled.working_state import Problem, Scratch

PROVEN = 1
OPEN = 0
REFUTED = -1


@njit(cache=True, nogil=True, error_model="numpy")
def _ends_hold(problem: Problem, c: Array, r: Array, k: Scratch) -> bool:
    """Whether every mix of the cells' ends, losses taken off, is positive: a depth-first walk, tip to base."""
    n = problem.parent.shape[0]
    m = problem.link.shape[1]
    T, w, v, B, size = k.work[8], k.rows[2], k.rows[3], k.work[9], k.rows[1]
    start(problem, k)
    i = n - 1
    down = True
    while True:
        p = problem.parent[i] if i < n else -1
        if down:
            if not eliminate_joint(problem, k, i):
                return False
            for x in range(m):
                k.F[i, x, x] -= GUARD * k.kept[i, x]
            if i == 1 and problem.exact:
                error = base(problem, k)
                if not positive_over_range(k.C, error, problem.lower[1], problem.upper[1], k.stack):
                    return False
                i, down = 2, False
                continue
            if p < 0:
                k.side[i] = 2
                if i == 0:
                    i, down = 1, False
                else:
                    i -= 1
                continue
            for x in range(m):
                size[x] = k.kept[i, x]
            if problem.slides[i]:
                slide(k.F[i], c[i], k.Fc[i])
            else:
                turn(k.F[i], k.angle[i, 0], k.angle[i, 1], k.Fc[i])
            spread(size, problem.slides[i], abs(c[i]) + r[i])
            if not loss(k.Fc[i], problem.slides[i], r[i], k.basis[i], k.inverse[i], k.metric[i], size, k.K[i], k.work):
                return False
            for x in range(m):
                k.kept[i, x] = size[x]
                k.saved_size[i, x] = k.size[p, x]
                for y in range(m):
                    k.saved[i, x, y] = k.A[p, x, y]
            k.side[i] = 0
        else:
            if i == n:
                return True
            if p >= 0:
                for x in range(m):
                    k.size[p, x] = k.saved_size[i, x]
                    for y in range(m):
                        k.A[p, x, y] = k.saved[i, x, y]
            k.side[i] += 1
            if k.side[i] >= 2 or r[i] == 0.0 or (r[i] > WHOLE and not problem.slides[i]):
                i += 1
                continue
        if problem.slides[i]:
            slide(k.F[i], c[i] + (r[i] if k.side[i] == 1 else -r[i]), B)
        elif r[i] > WHOLE:
            mean_of_turn(k.F[i], B)
        elif k.side[i] == 0:
            turn(k.F[i], k.angle[i, 2], k.angle[i, 3], B)
        else:
            turn(k.F[i], k.angle[i, 4], k.angle[i, 5], B)
        for x in range(m):
            s = k.kept[i, x]
            for y in range(m):
                B[x, y] -= k.K[i, x, y]
                s += abs(k.K[i, x, y])
            B[x, x] -= GUARD * s
        shift_onto(B, problem.place[i], k.A[p], k.size[p], T, w, v)
        i -= 1
        down = True


@njit(inline="always")
def test_box(problem: Problem, c: Array, r: Array, k: Scratch, share: Array) -> int:
    """Is the form positive over the box of cells c ± r?

    Args:
        problem: The statement.
        c: Centres, shape (n,); that of joint 1 is set to its worst if it is followed exactly.
        r: Half widths, shape (n,).
        k: Scratch.
        share: Out: what each joint's cell costs, relative to what is left at the centre, shape (n,).

    Returns:
        `PROVEN`, `OPEN`, or `REFUTED` if it is not positive at the centre (up to rounding).
    """
    n = problem.parent.shape[0]
    least = inward(problem, c, k)
    if not least > 0.0:
        return REFUTED
    total = outward(problem, c, r, k, share)
    if not total < least:
        return OPEN
    for i in range(n):
        k.angle[i, 0], k.angle[i, 1] = np.cos(c[i]), np.sin(c[i])
        k.angle[i, 2], k.angle[i, 3] = np.cos(c[i] - r[i]), np.sin(c[i] - r[i])
        k.angle[i, 4], k.angle[i, 5] = np.cos(c[i] + r[i]), np.sin(c[i] + r[i])
    return PROVEN if _ends_hold(problem, c, r, k) else OPEN
