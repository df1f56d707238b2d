"""What a form can lose between the ends of a joint's cell: matrices K with G(q) ⪰ (mix of the ends) − K, tested.

Notation of certificate.md: F_c is the form at the cell's centre seen from before the joint, r the cell's half width,
u = sin δ, w = cos δ − cos r ≥ 0, κ = 1 − cos r. For a turn

    G(c + δ) = mix + w [B + 2 S₂ sin δ + 2 C₂ (cos δ − 1)],     B = C₁ + (2 + 2 cos r) C₂,

and for a slide G(c + δ) = mix − (r² − δ²) Nᵀ F_c N. The part of K that matters comes from a spectral negative part in a
metric Y = basis basisᵀ; whatever that gives is only used if it passes `surely_positive`.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.compiled.dense_forms import add_spectrum, to_metric
from asmc_pin.condition.certificate.compiled.joint_steps import GUARD
from asmc_pin.numerics.cholesky import surely_positive
from asmc_pin.numerics.eigen import eigen

WHOLE = 1.4
"""Half width, rad, above which a turning joint is bounded by its mean over a turn and not by the ends of its cell."""

_SLACK = 1e-9


@njit(cache=True, nogil=True, error_model="numpy")
def clear(out: Array) -> None:
    """Write zeros."""
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            out[i, j] = 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def first_degree(F: Array, quarter: bool, out: Array) -> None:
    """C₁ of a turn about z: the entries between z and x, y rows; a quarter turn on (S₁) if asked."""
    m = F.shape[0]
    clear(out)
    for z in range(2, m, 3):
        for b in range(0, m, 3):
            x = F[z, b]
            y = F[z, b + 1]
            if quarter:
                x, y = -y, x
            out[z, b] = x
            out[b, z] = x
            out[z, b + 1] = y
            out[b + 1, z] = y


@njit(cache=True, nogil=True, error_model="numpy")
def add_second_degree(F: Array, factor: float, quarter: bool, out: Array) -> None:
    """Add to out factor · C₂ (or S₂): the traceless symmetric part of each 2 × 2 block of x, y rows."""
    m = F.shape[0]
    for a in range(0, m, 3):
        for b in range(0, m, 3):
            t1 = 0.5 * factor * (F[a, b] - F[a + 1, b + 1])
            t2 = 0.5 * factor * (F[a, b + 1] + F[a + 1, b])
            if quarter:
                t1, t2 = -t2, t1
            out[a, b] += t1
            out[a + 1, b + 1] -= t1
            out[a, b + 1] += t2
            out[a + 1, b] += t2


@njit(cache=True, nogil=True, error_model="numpy")
def mean_of_turn(F: Array, out: Array) -> None:
    """C₀: the mean of Z F Zᵀ over a whole turn."""
    m = F.shape[0]
    for i in range(m):
        for j in range(m):
            out[i, j] = F[i, j]
    for z in range(2, m, 3):
        for b in range(0, m, 3):
            for k in range(2):
                out[z, b + k] = 0.0
                out[b + k, z] = 0.0
    for a in range(0, m, 3):
        for b in range(0, m, 3):
            even = 0.5 * (F[a, b] + F[a + 1, b + 1])
            odd = 0.5 * (F[a + 1, b] - F[a, b + 1])
            out[a, b] = even
            out[a + 1, b + 1] = even
            out[a + 1, b] = odd
            out[a, b + 1] = -odd


@njit(cache=True, nogil=True, error_model="numpy")
def _minus_slide(F: Array, out: Array) -> None:
    """−Nᵀ F N, with N: v += ω × z."""
    m = F.shape[0]
    clear(out)
    for a in range(0, m, 6):
        for b in range(0, m, 6):
            out[a, b] = -F[a + 4, b + 4]
            out[a, b + 1] = F[a + 4, b + 3]
            out[a + 1, b] = F[a + 3, b + 4]
            out[a + 1, b + 1] = -F[a + 3, b + 3]


@njit(cache=True, nogil=True, error_model="numpy")
def loss(
    Fc: Array, slides: bool, r: float, basis: Array, inverse: Array, metric: Array, size: Array, K: Array, work: Array
) -> bool:
    """A matrix K ⪰ 0 with G(c + δ) ⪰ mix − K for |δ| ≤ r, where mix is of the cell's ends (or `mean_of_turn`).

    K is a sum of parts, weight · P, each with P + H ⪰ 0 and P ⪰ 0 (or, two-sided, P ± H ⪰ 0) for its own H.

    Args:
        Fc: Form at the cell's centre, seen from before the joint, shape (m, m).
        slides: Prismatic.
        r: Half width of the cell, rad or m.
        basis: Square root of the metric, shape (m, m).
        inverse: Its inverse.
        metric: basis basisᵀ, positive definite.
        size: Magnitudes of Fc's rows, shape (m,).
        K: Out, shape (m, m).
        work: Scratch, shape (8, m, m).

    Returns:
        False if a test did not pass: K is then worth nothing.
    """
    m = Fc.shape[0]
    H, W, V, T, S, P = work[0], work[1], work[2], work[3], work[4], work[5]
    d, e, slack = work[6, 0], work[6, 1], work[6, 2]
    for x in range(m):
        slack[x] = GUARD * size[x]
    if slides:
        for a in range(0, m, 6):
            slack[a] += slack[a + 4]
            slack[a + 1] += slack[a + 3]
    clear(K)
    whole = r > WHOLE
    parts = 1 if slides else (4 if whole else 3)
    cosine = np.cos(r)
    half = np.sin(0.5 * r)
    kappa = 2.0 * half * half * (1.0 + 1e-14)
    for part in range(parts):
        two_sided, spectral, weight = whole, True, 1.0
        if slides:
            two_sided, weight = False, r * r * (1.0 + 1e-14)
            _minus_slide(Fc, H)
        elif (whole and part < 2) or part == 0:
            first_degree(Fc, part == 1, H)
        else:
            clear(H)
        if not slides and part >= (2 if whole else 0):
            factor, quarter = 1.0, part == 3
            if not whole and part == 0:
                factor, weight = 2.0 + 2.0 * cosine, kappa
            elif not whole and part == 1:
                # The largest (cos δ − cos r) sin δ.
                x = min(0.25 * (cosine + np.sqrt(cosine * cosine + 8.0)), 1.0)
                third = (x - cosine) * np.sqrt(max(1.0 - x * x, 0.0)) * (1.0 + 1e-9) + 1e-14
                quarter, two_sided, spectral, weight = True, True, False, 2.0 * third
            elif not whole:
                factor, spectral, weight = -1.0, False, 0.5 * kappa * kappa
            add_second_degree(Fc, factor, quarter, H)
        norm = to_metric(H, inverse, T, W)
        share = _SLACK * norm if spectral else (1.0 + _SLACK) * norm
        for i in range(m):
            for j in range(m):
                P[i, j] = share * metric[i, j]
            P[i, i] += 4.0 * slack[i]
        if spectral:
            eigen(W, V, d, e)
            add_spectrum(basis, V, d, two_sided, P, e)
        for side in range(2):
            sign = 1.0 if side == 0 else (-1.0 if two_sided else 0.0)
            for i in range(m):
                for j in range(i + 1):
                    S[i, j] = P[i, j] + sign * H[i, j]
            if not surely_positive(S, slack, T):
                return False
        for i in range(m):
            for j in range(m):
                K[i, j] += weight * P[i, j]
    return True
