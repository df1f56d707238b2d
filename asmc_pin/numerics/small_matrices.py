"""Small dense linear algebra for compiled loops: Cholesky, symmetric eigenvalues, extreme eigenpairs.

Matrices here are joint-space (at most some ten rows), where a call into LAPACK costs more than the arithmetic. Every
function works in scratch arrays of the caller and allocates nothing.
"""

from __future__ import annotations

import numba
import numpy as np

from asmc_pin._typing import Array

_EPS = float(np.finfo(np.float64).eps)


@numba.njit(cache=True, nogil=True, error_model="numpy")
def cholesky(matrix: Array, factor: Array) -> bool:
    """Lower Cholesky factor of a symmetric matrix (lower triangle read); False if it is not positive definite."""
    n = matrix.shape[0]
    for i in range(n):
        for j in range(i):
            total = matrix[i, j]
            for k in range(j):
                total -= factor[i, k] * factor[j, k]
            factor[i, j] = total / factor[j, j]
        pivot = matrix[i, i]
        for k in range(i):
            pivot -= factor[i, k] * factor[i, k]
        if not pivot > 0.0:
            return False
        factor[i, i] = np.sqrt(pivot)
    return True


@numba.njit(cache=True, nogil=True, error_model="numpy")
def solve_lower(factor: Array, x: Array) -> None:
    """Overwrite the columns of x, shape (n, m), with L⁻¹ x."""
    n, m = x.shape
    for i in range(n):
        for k in range(i):
            weight = factor[i, k]
            for c in range(m):
                x[i, c] -= weight * x[k, c]
        scale = 1.0 / factor[i, i]
        for c in range(m):
            x[i, c] *= scale


@numba.njit(cache=True, nogil=True, error_model="numpy")
def solve_upper(factor: Array, x: Array) -> None:
    """Overwrite the columns of x, shape (n, m), with L⁻ᵀ x."""
    n, m = x.shape
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            weight = factor[k, i]
            for c in range(m):
                x[i, c] -= weight * x[k, c]
        scale = 1.0 / factor[i, i]
        for c in range(m):
            x[i, c] *= scale


@numba.njit(cache=True, nogil=True, error_model="numpy")
def gram(x: Array, out: Array) -> None:
    """Write xᵀ x, both triangles."""
    n, m = x.shape
    for i in range(m):
        for j in range(i + 1):
            total = 0.0
            for k in range(n):
                total += x[k, i] * x[k, j]
            out[i, j] = total
            out[j, i] = total


@numba.njit(cache=True, nogil=True, error_model="numpy")
def _tridiagonalise(a: Array, diagonal: Array, off: Array, p: Array) -> None:
    """Householder reduction of a symmetric matrix, which is destroyed; `off[i]` couples i and i + 1."""
    n = a.shape[0]
    for k in range(n - 2):
        norm2 = 0.0
        for i in range(k + 2, n):
            norm2 += a[i, k] * a[i, k]
        if norm2 == 0.0:
            off[k] = a[k + 1, k]
            continue
        head = a[k + 1, k]
        alpha = -np.copysign(np.sqrt(head * head + norm2), head)
        off[k] = alpha
        # Reflector I − w wᵀ / h, with w stored in the eliminated column.
        a[k + 1, k] = head - alpha
        h = -alpha * a[k + 1, k]
        projection = 0.0
        for i in range(k + 1, n):
            total = 0.0
            for j in range(k + 1, i + 1):
                total += a[i, j] * a[j, k]
            for j in range(i + 1, n):
                total += a[j, i] * a[j, k]
            p[i] = total / h
            projection += p[i] * a[i, k]
        projection /= 2.0 * h
        for i in range(k + 1, n):
            p[i] -= projection * a[i, k]
        for i in range(k + 1, n):
            for j in range(k + 1, i + 1):
                a[i, j] -= a[i, k] * p[j] + p[i] * a[j, k]
    for i in range(n):
        diagonal[i] = a[i, i]
    if n > 1:
        off[n - 2] = a[n - 1, n - 2]


@numba.njit(cache=True, nogil=True, error_model="numpy")
def eigenvalues(a: Array, values: Array, off: Array, p: Array) -> None:
    """Eigenvalues, in no order, of a symmetric matrix (lower triangle read, all of it destroyed).

    Householder tridiagonalisation and the implicit QL iteration: backward stable, so each value is right to a few
    units in the last place of the largest one.

    Args:
        a: Shape (n, n).
        values: Receives the eigenvalues, shape (n,).
        off: Scratch, shape (n,).
        p: Scratch, shape (n,).
    """
    n = a.shape[0]
    _tridiagonalise(a, values, off, p)
    off[n - 1] = 0.0
    for low in range(n):
        for _ in range(60):
            split = low
            while split < n - 1:
                size = abs(values[split]) + abs(values[split + 1])
                if abs(off[split]) <= _EPS * size:
                    break
                split += 1
            if split == low:
                break
            g = (values[low + 1] - values[low]) / (2.0 * off[low])
            r = np.sqrt(g * g + 1.0)
            g = values[split] - values[low] + off[low] / (g + np.copysign(r, g))
            s = 1.0
            c = 1.0
            shift = 0.0
            stopped = False
            for i in range(split - 1, low - 1, -1):
                f = s * off[i]
                b = c * off[i]
                r = np.sqrt(f * f + g * g)
                off[i + 1] = r
                if r == 0.0:
                    values[i + 1] -= shift
                    off[split] = 0.0
                    stopped = True
                    break
                s = f / r
                c = g / r
                g = values[i + 1] - shift
                r = (values[i] - g) * s + 2.0 * c * b
                shift = s * r
                values[i + 1] = g + shift
                g = c * r - b
            if stopped:
                continue
            values[low] -= shift
            off[low] = g
            off[split] = 0.0


@numba.njit(cache=True, nogil=True, error_model="numpy")
def eigenpairs(a: Array, vectors: Array) -> None:
    """Cyclic Jacobi: leaves the eigenvalues on the diagonal of `a` and the eigenvectors in the columns of `vectors`."""
    n = a.shape[0]
    for i in range(n):
        for j in range(n):
            vectors[i, j] = 1.0 if i == j else 0.0
    for _ in range(40):
        outside = 0.0
        inside = 0.0
        for i in range(n):
            inside += a[i, i] * a[i, i]
            for j in range(i):
                outside += a[i, j] * a[i, j]
        if outside <= _EPS * _EPS * inside or outside == 0.0:
            return
        for i in range(n):
            for j in range(i):
                if a[i, j] == 0.0:
                    continue
                theta = (a[i, i] - a[j, j]) / (2.0 * a[i, j])
                t = 1.0 / (abs(theta) + np.sqrt(theta * theta + 1.0))
                if theta < 0.0:
                    t = -t
                c = 1.0 / np.sqrt(t * t + 1.0)
                s = t * c
                for k in range(n):
                    x = a[k, j]
                    y = a[k, i]
                    a[k, j] = c * x - s * y
                    a[k, i] = s * x + c * y
                for k in range(n):
                    x = a[j, k]
                    y = a[i, k]
                    a[j, k] = c * x - s * y
                    a[i, k] = s * x + c * y
                for k in range(n):
                    x = vectors[k, j]
                    y = vectors[k, i]
                    vectors[k, j] = c * x - s * y
                    vectors[k, i] = s * x + c * y
