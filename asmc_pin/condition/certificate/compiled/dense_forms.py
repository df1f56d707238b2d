"""Small dense symmetric algebra for the proof: eigenpairs as a guess, Cholesky as a verdict.

Nothing that is *guessed* here (eigenpairs, negative parts) is trusted: each matrix that a proof uses is tested by
`surely_positive`, whose answer True is a theorem about the floats it was given.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from asmc_pin._typing import Array

SHIFT = 1e-13
"""Share of the diagonal taken off before a Cholesky decides. Rump (2006): success in float64 proves
S ⪰ −m γ_{m+1} diag(S), and m γ_{m+1} < 2e-14 for m ≤ 12 (docs/certificate.md, Floating point)."""


@njit(cache=True, nogil=True, error_model="numpy")
def surely_positive(S: Array, slack: Array, L: Array) -> bool:
    """Whether S − diag(slack) is positive definite, proven; S (m, m) lower triangle read, slack (m,) ≥ 0, L scratch."""
    m = S.shape[0]
    for i in range(m):
        for j in range(i):
            s = S[i, j]
            for k in range(j):
                s -= L[i, k] * L[j, k]
            L[i, j] = s * L[j, j]
        s = S[i, i] - SHIFT * abs(S[i, i]) - 1.000001 * slack[i] - 1e-290
        for k in range(i):
            s -= L[i, k] * L[i, k]
        if not s > 0.0:
            return False
        # The reciprocal is stored, which costs one rounding per entry more than Rump counts; SHIFT has room for it.
        L[i, i] = 1.0 / np.sqrt(s)
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def eigen(A: Array, V: Array, d: Array, e: Array) -> None:
    """Eigenvalues d and eigenvectors (columns of V) of a symmetric A (lower triangle read), to some 1e-14.

    Householder tridiagonalisation and implicit QL (Bowdler, Martin, Reinsch, Wilkinson 1968).
    """
    n = A.shape[0]
    for i in range(n):
        for j in range(i + 1):
            V[i, j] = A[i, j]
    for i in range(n - 1, 0, -1):
        h = 0.0
        scale = 0.0
        if i > 1:
            for k in range(i):
                scale += abs(V[i, k])
        if scale == 0.0:
            e[i] = V[i, i - 1]
        else:
            for k in range(i):
                V[i, k] /= scale
                h += V[i, k] * V[i, k]
            f = V[i, i - 1]
            g = -np.sqrt(h) if f >= 0.0 else np.sqrt(h)
            e[i] = scale * g
            h -= f * g
            V[i, i - 1] = f - g
            f = 0.0
            for j in range(i):
                V[j, i] = V[i, j] / h
                g = 0.0
                for k in range(j + 1):
                    g += V[j, k] * V[i, k]
                for k in range(j + 1, i):
                    g += V[k, j] * V[i, k]
                e[j] = g / h
                f += e[j] * V[i, j]
            hh = f / (h + h)
            for j in range(i):
                f = V[i, j]
                g = e[j] - hh * f
                e[j] = g
                for k in range(j + 1):
                    V[j, k] -= f * e[k] + g * V[i, k]
        d[i] = h
    d[0] = 0.0
    e[0] = 0.0
    for i in range(n):
        if d[i] != 0.0:
            for j in range(i):
                g = 0.0
                for k in range(i):
                    g += V[i, k] * V[k, j]
                for k in range(i):
                    V[k, j] -= g * V[k, i]
        d[i] = V[i, i]
        V[i, i] = 1.0
        for j in range(i):
            V[j, i] = 0.0
            V[i, j] = 0.0
    for i in range(1, n):
        e[i - 1] = e[i]
    e[n - 1] = 0.0
    for l in range(n):  # noqa: E741
        for _ in range(40):
            k = l
            while k < n - 1:
                dd = abs(d[k]) + abs(d[k + 1])
                if abs(e[k]) <= 2.3e-16 * dd:
                    break
                k += 1
            if k == l:
                break
            g = (d[l + 1] - d[l]) / (2.0 * e[l])
            r = np.sqrt(g * g + 1.0)
            g = d[k] - d[l] + e[l] / (g + (r if g >= 0.0 else -r))
            s = 1.0
            c = 1.0
            p = 0.0
            cut = False
            for i in range(k - 1, l - 1, -1):
                f = s * e[i]
                b = c * e[i]
                r = np.sqrt(f * f + g * g)
                e[i + 1] = r
                if r == 0.0:
                    d[i + 1] -= p
                    e[k] = 0.0
                    cut = True
                    break
                s = f / r
                c = g / r
                g = d[i + 1] - p
                r = (d[i] - g) * s + 2.0 * c * b
                p = s * r
                d[i + 1] = g + p
                g = c * r - b
                for j in range(n):
                    f = V[j, i + 1]
                    V[j, i + 1] = s * V[j, i] + c * f
                    V[j, i] = c * V[j, i] - s * f
            if cut:
                continue
            d[l] -= p
            e[l] = g
            e[k] = 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def to_metric(H: Array, inverse: Array, T: Array, out: Array) -> float:
    """Write inverse H inverseᵀ into out, scratch T; returns its Frobenius norm."""
    m = H.shape[0]
    for i in range(m):
        for j in range(m):
            s = 0.0
            for k in range(m):
                s += inverse[i, k] * H[k, j]
            T[i, j] = s
    total = 0.0
    for i in range(m):
        for j in range(i + 1):
            s = 0.0
            for k in range(m):
                s += T[i, k] * inverse[j, k]
            out[i, j] = s
            out[j, i] = s
            total += s * s if i == j else 2.0 * s * s
    return float(np.sqrt(total))


@njit(cache=True, nogil=True, error_model="numpy")
def add_spectrum(basis: Array, V: Array, d: Array, both: bool, K: Array, y: Array) -> None:
    """K += basis W₋ basisᵀ, or basis |W| basisᵀ if `both`, with W = V diag(d) Vᵀ; y (m,) is scratch."""
    m = V.shape[0]
    for k in range(m):
        weight = max(-d[k], 0.0)
        if both:
            weight = abs(d[k])
        if weight > 0.0:
            for i in range(m):
                s = 0.0
                for j in range(m):
                    s += basis[i, j] * V[j, k]
                y[i] = s
            for i in range(m):
                for j in range(i + 1):
                    K[i, j] += weight * y[i] * y[j]
    for i in range(m):
        for j in range(i):
            K[j, i] = K[i, j]
