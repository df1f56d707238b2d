"""The metric in which a joint's loss is made small: a good choice costs boxes, a bad one never soundness."""

from __future__ import annotations

import numpy as np
from numba import njit

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.compiled.working_state import Problem, Scratch
from asmc_pin.numerics.cholesky import invert_lower, lifted_cholesky

LIFT = 0.03
"""Least pivot of a metric over its diagonal. A point mass resists no turning about itself, yet a turn of the joint
takes it elsewhere: in a metric that is singular at the cell's centre the loss between two angles has no bound."""


@njit(cache=True, nogil=True, error_model="numpy")
def metric_of(problem: Problem, k: Scratch, i: int, Om: Array) -> None:
    """The metric in which joint i's losses are made small: what the joints before it can do, and a share of the rigid.

    Args:
        problem: The statement.
        k: Scratch; basis[i], inverse[i], metric[i] are written.
        i: The joint.
        Om: J P⁻¹ Jᵀ of the parent's twist, seen from the joint's frame at q = 0, shape (m, m).
    """
    m = Om.shape[0]
    p = m // 6
    L, Li, G, H = k.work[0], k.work[1], k.work[2], k.work[3]
    L6, Li6 = k.six[0], k.six[1]
    for x in range(m):
        for y in range(m):
            L[x, y] = 0.0
            Li[x, y] = 0.0
    lifted_cholesky(k.composite[i], LIFT, L6)
    invert_lower(L6, Li6)
    nu = 1.0
    if p == 2:
        # Weigh the two twists as the joints before this one can move them.
        a = 0.0
        b = 0.0
        for x in range(6):
            for y in range(6):
                a += Om[x, y] * k.composite[i, x, y]
                b += Om[6 + x, 6 + y] * k.composite[i, x, y]
        nu = np.sqrt(np.sqrt(max(b, 1e-30) / max(a, 1e-30)))
        nu = min(max(nu, 1e-6), 1e6)
    for x in range(6):
        for y in range(x + 1):
            if p == 1:
                L[x, y] = L6[x, y]
                Li[x, y] = Li6[x, y]
            else:
                L[x, y] = nu * L6[x, y]
                Li[x, y] = Li6[x, y] / nu
                L[6 + x, 6 + y] = L6[x, y] / nu
                Li[6 + x, 6 + y] = nu * Li6[x, y]
    # In coordinates where the rigid metric is 1: compliance, scaled to trace 1, plus spread · 1.
    for x in range(m):
        for y in range(m):
            s = 0.0
            for z in range(m):
                s += Om[x, z] * L[z, y]
            G[x, y] = s
    trace = 0.0
    for x in range(m):
        for y in range(x + 1):
            s = 0.0
            for z in range(m):
                s += L[z, x] * G[z, y]
            H[x, y] = s
        trace += H[x, x]
    f = 1.0 / max(trace, 1e-300)
    for x in range(m):
        for y in range(x + 1):
            H[x, y] *= f
        H[x, x] += problem.spread
    lifted_cholesky(H, LIFT, G)
    invert_lower(G, H)
    # basis = L G⁻ᵀ, inverse = Gᵀ L⁻¹.
    for x in range(m):
        for y in range(m):
            s = 0.0
            r = 0.0
            for z in range(m):
                s += L[x, z] * H[y, z]
                r += G[z, x] * Li[z, y]
            k.basis[i, x, y] = s
            k.inverse[i, x, y] = r
    for x in range(m):
        for y in range(x + 1):
            s = 0.0
            for z in range(m):
                s += k.basis[i, x, z] * k.basis[i, y, z]
            k.metric[i, x, y] = s
            k.metric[i, y, x] = s
