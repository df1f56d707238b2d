"""How a joint carries a quadratic form of its body's twist to its parent: eliminate the joint, turn or slide, shift.

A form A has shape (m, m), m = 6 p: p twists of three angular and three linear components each, at the origin of the
joint's frame, whose z axis is the joint's axis. p = 1 for the weighted condition, 2 for Lemma 1 (certificate.md, Lift).

Rounding: each function that a proof rests on also gives, per row, the sum of the magnitudes that took part. `GUARD`
times it, taken off the diagonal, makes the computed form a lower bound of the exact one (Gershgorin).
"""

from __future__ import annotations

from numba import njit

from asmc_pin._typing import Array

GUARD = 2e-14
"""More than the roundings (below 60, each 1.1e-16) that any entry passes between two compensations."""


@njit(cache=True, nogil=True, error_model="numpy")
def eliminate(
    A: Array, size: Array, axis: int, R: Array, T: Array, F: Array, U: Array, D: Array, Ua: Array, Da: Array
) -> bool:
    """Minimise over the joint's own velocities: F ⪯ A − U D⁻¹ Uᵀ, with D = Rᵀ A_axis R + T.

    Args:
        A: Form of the body, shape (m, m), exact as given.
        size: On entry the row sums of |A|; on exit the magnitudes for F, shape (m,).
        axis: Row of the joint's motion within a twist: 2 turning, 5 sliding.
        R: How the joint's velocities enter the p twists, shape (p, e).
        T: The joint's own form, shape (e, e).
        F: Out, shape (m, m).
        U: Out, before elimination, shape (e, m).
        D: Out, before elimination, shape (e, e).
        Ua: Scratch as U, as are `Da` as D.
        Da: Scratch.

    Returns:
        False if D is not surely positive definite.
    """
    m = A.shape[0]
    p, e = R.shape
    for k in range(e):
        for x in range(m):
            s = 0.0
            a = 0.0
            for b in range(p):
                v = A[x, 6 * b + axis] * R[b, k]
                s += v
                a += abs(v)
            U[k, x] = s
            Ua[k, x] = a
    for k in range(e):
        for j in range(e):
            s = T[k, j]
            a = abs(T[k, j])
            for b in range(p):
                s += R[b, k] * U[j, 6 * b + axis]
                a += abs(R[b, k]) * Ua[j, 6 * b + axis]
            D[k, j] = s
            Da[k, j] = a
    for x in range(m):
        for y in range(m):
            F[x, y] = A[x, y]
    if e == 1:
        total = 0.0
        for x in range(m):
            total += Ua[0, x]
        d = D[0, 0] - GUARD * (total + Da[0, 0])
        if not d > 1e-10 * Da[0, 0]:
            return False
        r = 1.0 / d
        for x in range(m):
            f = U[0, x] * r
            for y in range(x + 1):
                F[x, y] -= f * U[0, y]
            size[x] += Ua[0, x] * (1.0 + total * r)
    else:
        # y first: its own form is +1, so that the order never meets a vanishing pivot where x still has room.
        t0 = 0.0
        t1 = 0.0
        for x in range(m):
            t0 += Ua[0, x]
            t1 += Ua[1, x]
        d = D[1, 1] - GUARD * (t1 + Da[1, 1] + Da[0, 1])
        if not d > 1e-10 * Da[1, 1]:
            return False
        r = 1.0 / d
        g = D[0, 1] * r
        ga = Da[0, 1] * r
        d0 = D[0, 0] - g * D[0, 1]
        d0a = Da[0, 0] + ga * Da[0, 1]
        t0 += ga * t1
        d0 -= GUARD * (t0 + d0a + Da[0, 1])
        if not d0 > 1e-10 * d0a:
            return False
        r0 = 1.0 / d0
        for x in range(m):
            f = U[1, x] * r
            u = U[0, x] - g * U[1, x]
            ua = Ua[0, x] + ga * Ua[1, x]
            f0 = u * r0
            for y in range(x + 1):
                F[x, y] -= f * U[1, y] + f0 * (U[0, y] - g * U[1, y])
            size[x] += Ua[1, x] * (1.0 + t1 * r) + ua * (1.0 + t0 * r0)
    for x in range(m):
        for y in range(x):
            F[y, x] = F[x, y]
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def turn(A: Array, c: float, s: float, out: Array) -> None:
    """Write Z A Zᵀ into out: the form seen from before a turn about z with cosine c and sine s."""
    m = A.shape[0]
    for i in range(m):
        for b in range(0, m, 3):
            x = A[i, b]
            y = A[i, b + 1]
            out[i, b] = c * x - s * y
            out[i, b + 1] = s * x + c * y
            out[i, b + 2] = A[i, b + 2]
    for b in range(0, m, 3):
        for j in range(b + 2):
            x = out[b, j]
            y = out[b + 1, j]
            out[b, j] = c * x - s * y
            out[b + 1, j] = s * x + c * y
    for i in range(m):
        for j in range(i):
            out[j, i] = out[i, j]


@njit(cache=True, nogil=True, error_model="numpy")
def slide(A: Array, q: float, out: Array) -> None:
    """Write (1 + q N)ᵀ A (1 + q N) into out: the form seen from before a slide by q along z (N: v += ω × z)."""
    m = A.shape[0]
    for i in range(m):
        for b in range(0, m, 6):
            out[i, b] = A[i, b] - q * A[i, b + 4]
            out[i, b + 1] = A[i, b + 1] + q * A[i, b + 3]
            for k in range(2, 6):
                out[i, b + k] = A[i, b + k]
    for b in range(0, m, 6):
        for j in range(m):
            out[b, j] -= q * out[b + 4, j]
            out[b + 1, j] += q * out[b + 3, j]
    for i in range(m):
        for j in range(i):
            out[j, i] = out[i, j]


@njit(cache=True, nogil=True, error_model="numpy")
def spread(size: Array, slides: bool, q: float) -> None:
    """Magnitudes after `turn` (any angle) or `slide` (by at most q), in place."""
    m = size.shape[0]
    if slides:
        for b in range(0, m, 6):
            size[b] += q * size[b + 4]
            size[b + 1] += q * size[b + 3]
        for x in range(m):
            size[x] *= 1.0 + q
    else:
        for b in range(0, m, 3):
            pair = 2.0 * (size[b] + size[b + 1])
            size[b] = pair
            size[b + 1] = pair
            size[b + 2] *= 2.0


@njit(cache=True, nogil=True, error_model="numpy")
def shift_onto(B: Array, X: Array, A: Array, size: Array, T: Array, w: Array, v: Array) -> None:
    """A += Xᵀ B X for each pair of twists, rounded down; size becomes the row sums of |A|.

    Args:
        B: Form in the joint's frame at q = 0, shape (m, m).
        X: Motion transform from the parent's frame, shape (6, 6).
        A: The parent's form, shape (m, m), in and out.
        size: Out, shape (m,).
        T: Scratch (m, m), as are w and v (m,).
        w: Scratch.
        v: Scratch.
    """
    m = B.shape[0]
    for b in range(0, m, 6):
        for i in range(6):
            s = 0.0
            for j in range(6):
                s += abs(X[i, j])
            w[b + i] = s
    for i in range(m):
        s = 0.0
        for j in range(m):
            s += abs(B[i, j]) * w[j]
        v[i] = s
    for i in range(m):
        for b in range(0, m, 6):
            for j in range(6):
                s = 0.0
                for k in range(6):
                    s += B[i, b + k] * X[k, j]
                T[i, b + j] = s
    for a in range(0, m, 6):
        for i in range(6):
            for j in range(a + i + 1):
                s = 0.0
                for k in range(6):
                    s += X[k, i] * T[a + k, j]
                A[a + i, j] += s
    for a in range(0, m, 6):
        for i in range(6):
            s = 0.0
            for k in range(6):
                s += abs(X[k, i]) * v[a + k]
            w[a + i] = s
    for i in range(m):
        for j in range(i):
            A[j, i] = A[i, j]
    for i in range(m):
        s = w[i]
        for j in range(m):
            s += abs(A[i, j])
        A[i, i] -= GUARD * s
        size[i] = s
