"""Cholesky factors of small matrices, and what is solved with them; compiled, nothing allocated.

Joint-space matrices have at most some ten rows, where a call into LAPACK costs more than the arithmetic.
"""

from __future__ import annotations

import numba
import numpy as np

from asmc_pin._typing import Array, IntArray
from asmc_pin.numerics.short_loops import short_loops

SHIFT = 1e-13
"""Share of the diagonal taken off before a Cholesky decides. Rump (2006): success in float64 proves
S ⪰ −m γ_{m+1} diag(S), and m γ_{m+1} < 2e-14 for m ≤ 12 (docs/certificate.md, Floating point)."""


@numba.njit(cache=True, nogil=True, error_model="numpy")
def cholesky(matrix: Array, factor: Array) -> bool:
    """Lower Cholesky factor of a symmetric matrix (lower triangle read); False if it is not positive definite.

    The factor may take the matrix's own place.
    """
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
def lifted_cholesky(A: Array, lift: float, L: Array) -> None:
    """Cholesky factor L of A, positive definite but for rounding; small pivots are lifted to a part of the diagonal."""
    n = A.shape[0]
    for i in range(n):
        for j in range(i):
            s = A[i, j]
            for q in range(j):
                s -= L[i, q] * L[j, q]
            L[i, j] = s / L[j, j]
            L[j, i] = 0.0
        s = A[i, i]
        for q in range(i):
            s -= L[i, q] * L[i, q]
        L[i, i] = np.sqrt(max(s, lift * abs(A[i, i]) + 1e-12))


@numba.njit(cache=True, nogil=True, error_model="numpy")
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


@numba.njit(cache=True, nogil=True, error_model="numpy")
def invert_lower(L: Array, out: Array) -> None:
    """Write L⁻¹ of a lower triangular L, zeros above the diagonal included."""
    n = L.shape[0]
    for j in range(n):
        for i in range(j):
            out[i, j] = 0.0
        out[j, j] = 1.0 / L[j, j]
        for i in range(j + 1, n):
            s = 0.0
            for q in range(j, i):
                s -= L[i, q] * out[q, j]
            out[i, j] = s / L[i, i]


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
def solve_face(matrix: Array, rhs: Array, face: IntArray, count: int, factor: Array, solution: Array) -> None:
    """Solve matrix[F, F] x[F] = rhs[F] by Cholesky, F the first `count` entries of `face`; leave the rest of x.

    NaN where the matrix is not positive definite.
    """
    for i in range(count):
        for j in range(i + 1):
            factor[i, j] = matrix[face[i], face[j]]
    if not cholesky(factor[:count, :count], factor[:count, :count]):
        for i in range(count):
            solution[face[i]] = np.nan
        return
    for i in range(count):
        total = rhs[face[i]]
        for k in range(i):
            total -= factor[i, k] * solution[face[k]]
        solution[face[i]] = total / factor[i, i]
    for i in range(count - 1, -1, -1):
        total = solution[face[i]]
        for k in range(i + 1, count):
            total -= factor[k, i] * solution[face[k]]
        solution[face[i]] = total / factor[i, i]


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


@short_loops
def solve_shifted(matrix: Array, rows: Array, shift: int, rhs: int, x: int, factor: Array) -> None:
    """Solve (matrix + diag(rows[shift])) rows[x] = rows[rhs] by Cholesky; NaN where that is not positive definite.

    Three rows of one array, so that a caller need not make views of them. On and below its diagonal `factor` then holds
    the factor, with the reciprocals of its pivots on the diagonal.
    """
    n = matrix.shape[0]
    for i in range(n):
        for j in range(i):
            total = matrix[i, j]
            for k in range(j):
                total -= factor[i, k] * factor[j, k]
            factor[i, j] = total * factor[j, j]
        total = matrix[i, i] + rows[shift, i]
        for k in range(i):
            total -= factor[i, k] * factor[i, k]
        factor[i, i] = 1.0 / np.sqrt(total)
        total = rows[rhs, i]
        for k in range(i):
            total -= factor[i, k] * rows[x, k]
        rows[x, i] = total * factor[i, i]
    for i in range(n - 1, -1, -1):
        total = rows[x, i]
        for k in range(i + 1, n):
            total -= factor[k, i] * rows[x, k]
        rows[x, i] = total * factor[i, i]
