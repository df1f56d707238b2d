"""Congruences and spectral parts of the symmetric forms of the proof."""

from __future__ import annotations

import numpy as np
from numba import njit

from asmc_pin._typing import Array


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
