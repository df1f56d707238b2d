"""From the base to the tip at the centre of a box: the critical motion, and what each joint's cell costs there."""

from __future__ import annotations

import numpy as np
from numba import njit

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.compiled.cell_loss import loss
from asmc_pin.condition.certificate.compiled.joint_steps import spread, turn
from asmc_pin.condition.certificate.compiled.loss_metric import metric_of
from asmc_pin.condition.certificate.compiled.working_state import Problem, Scratch

CRITICAL = 16.0
"""Weight of the critical motion against all motions together: neither does alone. Boxes tested of Lemma 1 at weights of
1, 4, 16 and without the other: kinova at f = 1: 11,845, 12,561, 14,547, 154,317; xarm7 at f = 0.53: over 100,000,
over 40,000, 18,035, 26,477."""


@njit(cache=True, nogil=True, error_model="numpy")
def _relative_size(Ω: Array, K: Array, product: Array) -> float:
    """√tr(Ω K Ω K), the Frobenius norm of a loss K where the compliance Ω is 1; `product` is scratch."""
    m = K.shape[0]
    for x in range(m):
        for y in range(m):
            s = 0.0
            for z in range(m):
                s += Ω[x, z] * K[z, y]
            product[x, y] = s
    total = 0.0
    for x in range(m):
        for y in range(m):
            total += product[x, y] * product[y, x]
    return float(np.sqrt(max(total, 0.0)))


@njit(cache=True, nogil=True, error_model="numpy")
def outward(problem: Problem, c: Array, r: Array, k: Scratch, share: Array) -> float:
    """Base to tip at the centre: the critical motion, metrics, and what each joint's cell costs.

    Must follow `inward`. The critical motion has unit velocity at the base joint with the least pivot. `share` is each
    joint's loss relative to what is left at the centre: in the critical motion, and (Frobenius) over all motions, which
    tells the joints apart where the box is wide and its centre says little of it.

    Returns:
        The sum of the losses in the critical motion.
    """
    n = problem.parent.shape[0]
    m = problem.link.shape[1]
    p, e = problem.motion.shape[1], problem.motion.shape[2]
    before, Om, turned, tmp = k.rows[0], k.work[6], k.work[7], k.work[8]
    total = 0.0
    weakest = 0.0
    for i in range(n):
        share[i] = 0.0
        parent = problem.parent[i]
        axis = 5 if problem.slides[i] else 2
        X = problem.place[i]
        # D⁻¹ of this joint, at the base after the second joint's exact elimination.
        if i == 0 and problem.exact:
            cs, sn = np.cos(c[1]), np.sin(c[1])
            cc, ss = cs * cs - sn * sn, 2.0 * sn * cs
            for a in range(e):
                for b in range(e):
                    k.D[0, a, b] = (
                        k.C[0, a, b] + cs * k.C[1, a, b] + sn * k.C[2, a, b] + cc * k.C[3, a, b] + ss * k.C[4, a, b]
                    )
        if e == 1:
            i00, i01, i11 = 1.0 / k.D[i, 0, 0], 0.0, 0.0
        else:
            det = k.D[i, 0, 0] * k.D[i, 1, 1] - k.D[i, 0, 1] ** 2
            i00, i01, i11 = k.D[i, 1, 1] / det, -k.D[i, 0, 1] / det, k.D[i, 0, 0] / det
        twist, Ω = k.twist[i], k.compliance[i]
        if parent < 0:
            weakest = i00
            for x in range(m):
                twist[x] = 0.0
                for y in range(m):
                    Ω[x, y] = 0.0
            # The weakest direction of D (its inverse's largest), at unit size of x.
            y1 = i01 / i00 if e == 2 else 0.0
            for b in range(p):
                twist[6 * b + axis] = problem.motion[i, b, 0] + (problem.motion[i, b, 1] * y1 if e == 2 else 0.0)
        else:
            for b in range(0, m, 6):
                for x in range(6):
                    s = 0.0
                    for y in range(6):
                        s += X[x, y] * k.twist[parent, b + y]
                    before[b + x] = s
            for x in range(m):
                for b in range(0, m, 6):
                    for y in range(6):
                        s = 0.0
                        for z in range(6):
                            s += k.compliance[parent, x, b + z] * X[y, z]
                        tmp[x, b + y] = s
            for b in range(0, m, 6):
                for x in range(6):
                    for y in range(m):
                        s = 0.0
                        for z in range(6):
                            s += X[x, z] * tmp[b + z, y]
                        Om[b + x, y] = s
            if not (problem.exact and i == 1):
                metric_of(problem, k, i, Om)
                size = k.rows[1]
                for x in range(m):
                    size[x] = k.kept[i, x]
                spread(size, problem.slides[i], abs(c[i]) + r[i])
                if not loss(
                    k.Fc[i], problem.slides[i], r[i], k.basis[i], k.inverse[i], k.metric[i], size, k.K[i], k.work
                ):
                    share[i] = np.inf
                else:
                    s = 0.0
                    for x in range(m):
                        for y in range(m):
                            s += before[x] * k.K[i, x, y] * before[y]
                    share[i] = s
                total += share[i]
                # The loss has used the scratch: make Om again.
                for b in range(0, m, 6):
                    for x in range(6):
                        for y in range(m):
                            s = 0.0
                            for z in range(6):
                                s += X[x, z] * tmp[b + z, y]
                            Om[b + x, y] = s
                if share[i] < np.inf:
                    share[i] = CRITICAL * weakest * share[i] + _relative_size(Om, k.K[i], turned)
            # Into the joint's own frame, then past the joint.
            if problem.slides[i]:
                for b in range(0, m, 6):
                    before[b + 3] += c[i] * before[b + 1]
                    before[b + 4] -= c[i] * before[b]
                for x in range(m):
                    for y in range(m):
                        turned[x, y] = Om[x, y]
                for b in range(0, m, 6):
                    for y in range(m):
                        turned[b + 3, y] += c[i] * turned[b + 1, y]
                        turned[b + 4, y] -= c[i] * turned[b, y]
                for b in range(0, m, 6):
                    for x in range(m):
                        turned[x, b + 3] += c[i] * turned[x, b + 1]
                        turned[x, b + 4] -= c[i] * turned[x, b]
            else:
                cs, sn = np.cos(c[i]), np.sin(c[i])
                for b in range(0, m, 3):
                    x0, y0 = before[b], before[b + 1]
                    before[b] = cs * x0 + sn * y0
                    before[b + 1] = -sn * x0 + cs * y0
                turn(Om, cs, -sn, turned)
            u0 = 0.0
            u1 = 0.0
            for x in range(m):
                u0 += k.U[i, 0, x] * before[x]
                if e == 2:
                    u1 += k.U[i, 1, x] * before[x]
            x0 = -(i00 * u0 + i01 * u1)
            x1 = -(i01 * u0 + i11 * u1)
            for x in range(m):
                twist[x] = before[x]
            for b in range(p):
                twist[6 * b + axis] += problem.motion[i, b, 0] * x0 + (problem.motion[i, b, 1] * x1 if e == 2 else 0.0)
            # Ψ Om Ψᵀ with Ψ = 1 − S R D⁻¹ Uᵀ: rows, then columns.
            for pas in range(2):
                for y in range(m):
                    u0 = 0.0
                    u1 = 0.0
                    for x in range(m):
                        v = turned[x, y] if pas == 0 else turned[y, x]
                        u0 += k.U[i, 0, x] * v
                        if e == 2:
                            u1 += k.U[i, 1, x] * v
                    x0 = i00 * u0 + i01 * u1
                    x1 = i01 * u0 + i11 * u1
                    for b in range(p):
                        v = problem.motion[i, b, 0] * x0 + (problem.motion[i, b, 1] * x1 if e == 2 else 0.0)
                        if pas == 0:
                            turned[6 * b + axis, y] -= v
                        else:
                            turned[y, 6 * b + axis] -= v
            for x in range(m):
                for y in range(m):
                    Ω[x, y] = turned[x, y]
        for a in range(p):
            for b in range(p):
                v = i00 * problem.motion[i, a, 0] * problem.motion[i, b, 0]
                if e == 2:
                    v += i01 * (
                        problem.motion[i, a, 0] * problem.motion[i, b, 1]
                        + problem.motion[i, a, 1] * problem.motion[i, b, 0]
                    )
                    v += i11 * problem.motion[i, a, 1] * problem.motion[i, b, 1]
                Ω[6 * a + axis, 6 * b + axis] += v
    return total
