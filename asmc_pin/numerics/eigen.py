"""Eigenvalues and eigenvectors of small symmetric matrices; compiled, nothing allocated.

Householder tridiagonalisation and implicit QL (Bowdler, Martin, Reinsch, Wilkinson, "The QR and QL algorithms for
symmetric matrices", Numerische Mathematik 11, 1968): backward stable, so each eigenvalue is right to a few units in the
last place of the largest one.
"""

from __future__ import annotations

import numba
import numpy as np

from asmc_pin._typing import Array


@numba.njit(cache=True, nogil=True, error_model="numpy")
def eigen(A: Array, V: Array, d: Array, e: Array) -> None:
    """Eigenvalues d, in no order, and eigenvectors (columns of V) of a symmetric A (lower triangle read); e scratch."""
    n = A.shape[0]
    for i in range(n):
        for j in range(i + 1):
            V[i, j] = A[i, j]
    _decompose(V, d, e, True)


@numba.njit(cache=True, nogil=True, error_model="numpy")
def eigenvalues(A: Array, d: Array, e: Array) -> None:
    """Eigenvalues d, in no order, of a symmetric A (lower triangle read, all of it destroyed); e is scratch."""
    _decompose(A, d, e, False)


@numba.njit(cache=True, nogil=True, error_model="numpy")
def _decompose(V: Array, d: Array, e: Array, vectors: bool) -> None:
    _tridiagonalise(V, d, e, vectors)
    _iterate(V, d, e, vectors)


@numba.njit(cache=True, nogil=True, error_model="numpy")
def _tridiagonalise(V: Array, d: Array, e: Array, vectors: bool) -> None:
    """Diagonal d and off-diagonal e (e[i] couples i and i + 1) of VᵀAV, with A in V's lower triangle at first."""
    n = V.shape[0]
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
                if vectors:
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
        if vectors:
            if d[i] != 0.0:
                for j in range(i):
                    g = 0.0
                    for k in range(i):
                        g += V[i, k] * V[k, j]
                    for k in range(i):
                        V[k, j] -= g * V[k, i]
            for j in range(i):
                V[j, i] = 0.0
                V[i, j] = 0.0
        d[i] = V[i, i]
        if vectors:
            V[i, i] = 1.0
    for i in range(1, n):
        e[i - 1] = e[i]
    e[n - 1] = 0.0


@numba.njit(cache=True, nogil=True, error_model="numpy")
def _iterate(V: Array, d: Array, e: Array, vectors: bool) -> None:
    """Implicit QL on what `_tridiagonalise` leaves."""
    n = V.shape[0]
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
                    # Nothing is left to chase further; the rotations so far have turned coordinate i + 1 by c.
                    d[i + 1] -= p
                    e[i] = b
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
                if vectors:
                    for j in range(n):
                        f = V[j, i + 1]
                        V[j, i + 1] = s * V[j, i] + c * f
                        V[j, i] = c * V[j, i] - s * f
            if cut:
                continue
            d[l] -= p
            e[l] = g
            e[k] = 0.0
