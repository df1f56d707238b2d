"""The last step of a proof: the first two joints, whose angles need no cells.

M does not depend on the first joint, and on the second only through a trigonometric polynomial of degree 2 with e × e
coefficients, Φ(q) = R₀ᵀ (A₀ + Xᵀ Z(q) F Z(q)ᵀ X) R₀ + T₀, which is followed over its whole range.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.compiled.joint_steps import GUARD

_DEPTH = 44


@njit(cache=True, nogil=True, error_model="numpy")
def base_polynomial(
    A: Array, axis: int, R: Array, T: Array, X: Array, F: Array, size: Array, coefficient: Array, s: Array
) -> float:
    """Coefficients of Φ: coefficient[k] for 1, cos q, sin q, cos 2q, sin 2q, each (e, e); returns its rounding error.

    Args:
        A: Form of the first body, shape (m, m).
        axis: Row of the first joint's motion: 2 turning, 5 sliding.
        R: Shape (p, e).
        T: Shape (e, e).
        X: From the first joint's frame to the second's at q = 0, shape (6, 6).
        F: Form of the second body after its joint's elimination, shape (m, m).
        size: Magnitudes of F's rows, shape (m,).
        coefficient: Out, shape (5, e, e).
        s: Scratch, shape (2, m).
    """
    m = A.shape[0]
    p, e = R.shape
    error = 0.0
    for k in range(e):
        for b in range(p):
            for j in range(6):
                s[k, 6 * b + j] = X[j, axis] * R[b, k]
    for k in range(e):
        for h in range(e):
            total = T[k, h]
            absolute = abs(total)
            for a in range(p):
                for b in range(p):
                    v = R[a, k] * A[6 * a + axis, 6 * b + axis] * R[b, h]
                    total += v
                    absolute += abs(v)
            c0, c1, s1, c2, s2 = total, 0.0, 0.0, 0.0, 0.0
            for i in range(0, m, 3):
                ux, uy, uz = s[k, i], s[k, i + 1], s[k, i + 2]
                for j in range(0, m, 3):
                    vx, vy, vz = s[h, j], s[h, j + 1], s[h, j + 2]
                    c0 += F[i + 2, j + 2] * uz * vz
                    fx, fy = F[i + 2, j], F[i + 2, j + 1]
                    c1 += uz * (fx * vx + fy * vy)
                    s1 += uz * (fx * vy - fy * vx)
                    fx, fy = F[i, j + 2], F[i + 1, j + 2]
                    c1 += vz * (fx * ux + fy * uy)
                    s1 += vz * (fx * uy - fy * ux)
                    even = 0.5 * (F[i, j] + F[i + 1, j + 1])
                    odd = 0.5 * (F[i + 1, j] - F[i, j + 1])
                    t1 = 0.5 * (F[i, j] - F[i + 1, j + 1])
                    t2 = 0.5 * (F[i, j + 1] + F[i + 1, j])
                    c0 += even * (ux * vx + uy * vy) + odd * (uy * vx - ux * vy)
                    c2 += t1 * (ux * vx - uy * vy) + t2 * (ux * vy + uy * vx)
                    s2 += t1 * (ux * vy + uy * vx) - t2 * (ux * vx - uy * vy)
            coefficient[0, k, h] = c0
            coefficient[1, k, h] = c1
            coefficient[2, k, h] = s1
            coefficient[3, k, h] = c2
            coefficient[4, k, h] = s2
            error += absolute
    # |Σ_xy s_x E_xy s_y| ≤ Σ_x s_x² Σ_y |E_xy| for a symmetric E; and the same with the pairs that a turn mixes.
    for k in range(e):
        for i in range(0, m, 3):
            big = size[i] + size[i + 1] + size[i + 2]
            error += 8.0 * big * (s[k, i] ** 2 + s[k, i + 1] ** 2 + s[k, i + 2] ** 2)
    return 4.0 * GUARD * error


@njit(cache=True, nogil=True, error_model="numpy")
def _least(C: Array, q: float) -> float:
    """Smallest eigenvalue of Φ(q), by its formula for e ≤ 2."""
    c, s = np.cos(q), np.sin(q)
    cc, ss = (c - s) * (c + s), 2.0 * s * c
    a = C[0, 0, 0] + c * C[1, 0, 0] + s * C[2, 0, 0] + cc * C[3, 0, 0] + ss * C[4, 0, 0]
    if C.shape[1] == 1:
        return float(a)
    b = C[0, 0, 1] + c * C[1, 0, 1] + s * C[2, 0, 1] + cc * C[3, 0, 1] + ss * C[4, 0, 1]
    d = C[0, 1, 1] + c * C[1, 1, 1] + s * C[2, 1, 1] + cc * C[3, 1, 1] + ss * C[4, 1, 1]
    half = 0.5 * (a - d)
    big = 0.5 * (a + d) + np.sqrt(half * half + b * b)
    if not big > 0.0:
        return float(min(a, d) - abs(b))
    # The product of the eigenvalues over the larger one: no cancellation but in the determinant.
    return float((a * d - b * b) / big)


@njit(cache=True, nogil=True, error_model="numpy")
def _bounds(C: Array) -> tuple[float, float]:
    """Bounds of ‖Φ − Φ₀‖ and of ‖Φ″‖ over all angles, and so of their magnitudes."""
    f1 = 0.0
    g1 = 0.0
    f2 = 0.0
    g2 = 0.0
    e = C.shape[1]
    for k in range(e):
        for h in range(e):
            f1 += C[1, k, h] ** 2
            g1 += C[2, k, h] ** 2
            f2 += C[3, k, h] ** 2
            g2 += C[4, k, h] ** 2
    if e == 1:
        one = np.sqrt(f1 + g1)
        two = np.sqrt(f2 + g2)
    else:
        one = np.sqrt(f1) + np.sqrt(g1)
        two = np.sqrt(f2) + np.sqrt(g2)
    return (one + two) * (1.0 + 1e-12), (one + 4.0 * two) * (1.0 + 1e-12)


@njit(cache=True, nogil=True, error_model="numpy")
def least_over_range(C: Array, lower: float, upper: float) -> tuple[float, float]:
    """Smallest eigenvalue of Φ found over a range of q, and where (a sample: no proof)."""
    count = 64
    step = (upper - lower) / count
    best = np.inf
    at = lower
    for k in range(count + 1):
        v = _least(C, lower + k * step)
        if v < best:
            best = v
            at = lower + k * step
    for _ in range(30):
        step *= 0.5
        for sign in (-1.0, 1.0):
            q = min(max(at + sign * step, lower), upper)
            v = _least(C, q)
            if v < best:
                best = v
                at = q
                break
    return best, at


@njit(cache=True, nogil=True, error_model="numpy")
def positive_over_range(C: Array, error: float, lower: float, upper: float, stack: Array) -> bool:
    """Whether Φ(q) is positive definite for every q in [lower, upper], proven.

    Φ ⪰ (mix of its values at a cell's ends) − ⅛ width² ‖Φ″‖; cells are halved until both ends bear that.

    Args:
        C: Coefficients, shape (5, e, e), each within `error` together.
        error: From `base_polynomial`.
        lower: rad.
        upper: rad.
        stack: Scratch, shape (64, 4).
    """
    size, curvature = _bounds(C)
    e = C.shape[1]
    trace = 0.0
    for k in range(e):
        trace += abs(C[0, k, k])
    # An eigenvalue by formula errs by some u·(magnitudes)²/λ_max ≤ u·magnitudes·(condition); asking the determinant's
    # quotient to exceed this much of the magnitudes covers it.
    error = error + 64.0 * GUARD * (trace + size)
    if e == 1 and C[0, 0, 0] - size > error:
        return True
    count = 8
    step = (upper - lower) / count
    for k in range(count):
        top = 1
        stack[0, 0] = lower + k * step
        stack[0, 1] = upper if k == count - 1 else lower + (k + 1) * step
        stack[0, 2] = _least(C, stack[0, 0])
        stack[0, 3] = _least(C, stack[0, 1])
        while top > 0:
            top -= 1
            a, b = stack[top, 0], stack[top, 1]
            fa, fb = stack[top, 2], stack[top, 3]
            if not min(fa, fb) > error:
                return False
            width = (b - a) + 1e-14
            if min(fa, fb) - 0.125 * width * width * curvature > error:
                continue
            if top + 2 > _DEPTH:
                return False
            q = 0.5 * (a + b)
            f = _least(C, q)
            stack[top, 0] = a
            stack[top, 1] = q
            stack[top, 2] = fa
            stack[top, 3] = f
            stack[top + 1, 0] = q
            stack[top + 1, 1] = b
            stack[top + 1, 2] = f
            stack[top + 1, 3] = fb
            top += 2
    return True
