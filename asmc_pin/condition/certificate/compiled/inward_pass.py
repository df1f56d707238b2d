"""From the tip to the base: forms with their joints eliminated, at the centre of a box."""

from __future__ import annotations

import numpy as np
from numba import njit

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.compiled.first_joints import base_polynomial, least_over_range
from asmc_pin.condition.certificate.compiled.joint_steps import eliminate, shift_onto, slide, turn
from asmc_pin.condition.certificate.compiled.working_state import Problem, Scratch


@njit(cache=True, nogil=True, error_model="numpy")
def start(problem: Problem, k: Scratch) -> None:
    """Set the forms to those of the links alone."""
    n = problem.parent.shape[0]
    m = problem.link.shape[1]
    for i in range(n):
        for x in range(m):
            s = 0.0
            for y in range(m):
                k.A[i, x, y] = problem.link[i, x, y]
                s += abs(problem.link[i, x, y])
            k.size[i, x] = s


@njit(cache=True, nogil=True, error_model="numpy")
def eliminate_joint(problem: Problem, k: Scratch, i: int) -> bool:
    """Eliminate joint i of the present forms into F[i], with its magnitudes in kept[i]."""
    m = problem.link.shape[1]
    for x in range(m):
        k.kept[i, x] = k.size[i, x]
    axis = 5 if problem.slides[i] else 2
    return eliminate(k.A[i], k.kept[i], axis, problem.motion[i], problem.joint[i], k.F[i], k.U[i], k.D[i], k.Ua, k.Da)


@njit(cache=True, nogil=True, error_model="numpy")
def base(problem: Problem, k: Scratch) -> float:
    """Coefficients of the first two joints' polynomial into C; returns their rounding error."""
    return base_polynomial(
        k.A[0],
        5 if problem.slides[0] else 2,
        problem.motion[0],
        problem.joint[0],
        problem.place[1],
        k.F[1],
        k.kept[1],
        k.C,
        k.rows,
    )


@njit(cache=True, nogil=True, error_model="numpy")
def inward(problem: Problem, c: Array, k: Scratch) -> float:
    """Tip to base at the centre: forms, composites. Least pivot at the base (≤ 0: not positive there)."""
    n = problem.parent.shape[0]
    start(problem, k)
    for i in range(n):
        for x in range(6):
            for y in range(6):
                k.rigid[i, x, y] = problem.rigid[i, x, y]
    T, w, v = k.work[8], k.rows[2], k.rows[3]
    least = np.inf
    for i in range(n - 1, -1, -1):
        if not eliminate_joint(problem, k, i):
            return -1.0
        p = problem.parent[i]
        if i == 1 and problem.exact:
            base(problem, k)
            value, at = least_over_range(k.C, problem.lower[1], problem.upper[1])
            c[1] = at
            if value > 0.0 and k.C.shape[1] == 2:
                # The pivot of x, which is what a loss in the critical motion is taken from.
                cs, sn = np.cos(at), np.sin(at)
                cc, ss = cs * cs - sn * sn, 2.0 * sn * cs
                b = k.C[0, 0, 1] + cs * k.C[1, 0, 1] + sn * k.C[2, 0, 1] + cc * k.C[3, 0, 1] + ss * k.C[4, 0, 1]
                a = k.C[0, 0, 0] + cs * k.C[1, 0, 0] + sn * k.C[2, 0, 0] + cc * k.C[3, 0, 0] + ss * k.C[4, 0, 0]
                d = k.C[0, 1, 1] + cs * k.C[1, 1, 1] + sn * k.C[2, 1, 1] + cc * k.C[3, 1, 1] + ss * k.C[4, 1, 1]
                value = a - b * b / d
            least = min(least, value)
            break
        if p < 0:
            d = k.D[i, 0, 0]
            if k.D.shape[1] == 2:
                d -= k.D[i, 0, 1] ** 2 / k.D[i, 1, 1]
            least = min(least, d)
            continue
        if problem.slides[i]:
            slide(k.F[i], c[i], k.Fc[i])
            slide(k.rigid[i], c[i], k.composite[i])
        else:
            turn(k.F[i], np.cos(c[i]), np.sin(c[i]), k.Fc[i])
            turn(k.rigid[i], np.cos(c[i]), np.sin(c[i]), k.composite[i])
        shift_onto(k.Fc[i], problem.place[i], k.A[p], k.size[p], T, w, v)
        shift_onto(k.composite[i], problem.place[i], k.rigid[p], k.line[0], k.six[0], k.line[1], k.line[2])
    return least
