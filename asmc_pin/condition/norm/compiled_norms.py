"""Compiled figures of the condition, from joint angles to norms, and their gradients."""

from __future__ import annotations

import numba
import numpy as np

from asmc_pin._typing import Array
from asmc_pin.numerics.cholesky import cholesky, gram, solve_lower, solve_upper
from asmc_pin.numerics.eigen import eigen, eigenvalues
from asmc_pin.rigid_body.mass_gradient import bilinear_gradient
from asmc_pin.rigid_body.recursion import Links, fill_mass, scratch

LEMMA1 = 0  # ‖I − A‖₂, with A = M⁻¹M̄
WEIGHTED = 1  # max|1 − λ(A)|
LEMMA1_SCALE = 2  # −λ_min(N M + M N), N = M̄⁻¹: minus the factor of M̄ at which Lemma 1 breaks
WEIGHTED_SCALE = 3  # λ_max(A): twice the inverse of the factor of M̄ at which M̄ ≺ 2M breaks
BANDWIDTH = 4  # −λ_min(A)


# Elements are set in loops throughout: an assignment between arrays makes the compiler spend seconds on the message of
# a shape error that cannot occur.


@numba.njit(cache=True, nogil=True, error_model="numpy")
def fill_diagonal(diagonal: Array, root: bool, out: Array) -> None:
    """Write diag(diagonal), or the root of it, into out; diagonal (n,), out (n, n)."""
    for i in range(diagonal.size):
        for j in range(diagonal.size):
            out[i, j] = 0.0
        out[i, i] = np.sqrt(diagonal[i]) if root else diagonal[i]


@numba.njit(cache=True, nogil=True, error_model="numpy")
def subtract_from_identity(x: Array) -> None:
    """Replace x, (n, n), by I − x."""
    for i in range(x.shape[0]):
        for j in range(x.shape[0]):
            x[i, j] = (1.0 if i == j else 0.0) - x[i, j]


@numba.njit(cache=True, nogil=True, error_model="numpy")
def figure(kind: int, mass: Array, mbar: Array, factor: Array, x: Array, square: Array, work: Array) -> float:
    """One figure of one inertia matrix; NaN where M is not positive definite.

    Args:
        kind: `LEMMA1` … `BANDWIDTH`.
        mass: M, symmetric, armature included, shape (n, n).
        mbar: Diagonal of M̄, shape (n,).
        factor: Scratch, shape (n, n), as are `x` and `square`.
        x: Scratch.
        square: Scratch.
        work: Scratch, shape (2, n).
    """
    n = mass.shape[0]
    if not cholesky(mass, factor):
        return np.nan
    if kind == LEMMA1:
        fill_diagonal(mbar, False, x)
        solve_lower(factor, x)
        solve_upper(factor, x)
        subtract_from_identity(x)
        gram(x, square)
    elif kind in (WEIGHTED, WEIGHTED_SCALE):
        fill_diagonal(mbar, True, x)
        solve_lower(factor, x)
        gram(x, square)
    elif kind == LEMMA1_SCALE:
        for i in range(n):
            for j in range(n):
                square[i, j] = mass[i, j] * (1.0 / mbar[i] + 1.0 / mbar[j])
    else:
        for i in range(n):
            for j in range(n):
                square[i, j] = mass[i, j] / np.sqrt(mbar[i] * mbar[j])
    values = work[0]
    eigenvalues(square, values, work[1])
    least = most = float(values[0])
    for i in range(1, n):
        least, most = min(least, float(values[i])), max(most, float(values[i]))
    if kind == LEMMA1:
        return float(np.sqrt(max(most, 0.0)))
    if kind == WEIGHTED:
        return max(abs(1.0 - least), abs(1.0 - most))
    if kind == LEMMA1_SCALE:
        return -least
    if kind == WEIGHTED_SCALE:
        return most
    return -1.0 / most


@numba.njit(cache=True, nogil=True, error_model="numpy")
def figures_of_masses(kind: int, mass: Array, mbar: Array, out: Array) -> None:
    """The figure of each matrix of a batch: mass (B, n, n), mbar (B, n), out (B,)."""
    n = mass.shape[1]
    factor, x, square, work = np.empty((n, n)), np.empty((n, n)), np.empty((n, n)), np.empty((2, n))
    for b in range(mass.shape[0]):
        out[b] = figure(kind, mass[b], mbar[b], factor, x, square, work)


@numba.njit(cache=True, nogil=True, error_model="numpy")
def figures(kind: int, links: Links, armature: Array, q: Array, mbar: Array, out: Array) -> None:
    """The figure at each configuration of a batch: q (B, n), armature (B, n) or (1, n), out (B,)."""
    n = q.shape[1]
    placed = scratch(links.parent.size)
    mass, factor, x, square, work = (
        np.empty((n, n)),
        np.zeros((n, n)),
        np.empty((n, n)),
        np.empty((n, n)),
        np.empty((2, n)),
    )
    step = 1 if armature.shape[0] > 1 else 0
    for b in range(q.shape[0]):
        fill_mass(links, armature[step * b], q[b], placed, mass)
        out[b] = figure(kind, mass, mbar, factor, x, square, work)


@numba.njit(cache=True, nogil=True, error_model="numpy")
def extreme(kind: int, mass: Array, mbar: Array, left: Array, right: Array) -> tuple[float, float]:
    """A figure of one matrix and its derivative by M: d figure = c · leftᵀ dM right. Returns (figure, c)."""
    n = mass.shape[0]
    factor, square, vectors, x = np.zeros((n, n)), np.empty((n, n)), np.empty((n, n)), np.empty((n, n))
    if not cholesky(mass, factor):
        return np.nan, 0.0
    root = np.empty(n)
    for i in range(n):
        root[i] = np.sqrt(mbar[i])
    if kind == LEMMA1:
        fill_diagonal(mbar, False, x)
        solve_lower(factor, x)
        solve_upper(factor, x)
        subtract_from_identity(x)
        gram(x, square)
    elif kind in (WEIGHTED, WEIGHTED_SCALE):
        fill_diagonal(mbar, True, x)
        solve_lower(factor, x)
        gram(x, square)
    else:
        for i in range(n):
            for j in range(n):
                weight = 1.0 / mbar[i] + 1.0 / mbar[j] if kind == LEMMA1_SCALE else 1.0 / (root[i] * root[j])
                square[i, j] = mass[i, j] * weight
    values, off = np.empty(n), np.empty(n)
    eigen(square, vectors, values, off)
    best = 0
    for i in range(1, n):
        if kind == LEMMA1_SCALE:
            better = values[i] < values[best]
        elif kind == WEIGHTED:
            better = abs(1.0 - values[i]) > abs(1.0 - values[best])
        else:
            better = values[i] > values[best]
        if better:
            best = i
    value = values[best]
    pair = np.empty((n, 2))
    if kind == LEMMA1:
        # σ = uᵀ (I − M⁻¹M̄) v, so dσ = (M⁻¹u)ᵀ dM (M⁻¹M̄v).
        norm = np.sqrt(max(value, 0.0))
        for i in range(n):
            total = 0.0
            for j in range(n):
                total += x[i, j] * vectors[j, best]
            pair[i, 0] = total / norm if norm > 0.0 else 0.0
            pair[i, 1] = mbar[i] * vectors[i, best]
        solve_lower(factor, pair)
        solve_upper(factor, pair)
        for i in range(n):
            left[i], right[i] = pair[i, 0], pair[i, 1]
        return norm, 1.0
    if kind in (WEIGHTED, WEIGHTED_SCALE):
        # λ = wᵀ M̄^½ M⁻¹ M̄^½ w, so dλ = −zᵀ dM z with z = M⁻¹M̄^½ w.
        for i in range(n):
            pair[i, 0] = root[i] * vectors[i, best]
            pair[i, 1] = 0.0
        solve_lower(factor, pair)
        solve_upper(factor, pair)
        for i in range(n):
            left[i] = right[i] = pair[i, 0]
        if kind == WEIGHTED_SCALE:
            return value, -1.0
        return abs(1.0 - value), -1.0 if value > 1.0 else 1.0
    if kind == LEMMA1_SCALE:
        for i in range(n):
            left[i] = vectors[i, best] / mbar[i]
            right[i] = vectors[i, best]
        return -value, -2.0
    for i in range(n):
        left[i] = vectors[i, best] / root[i]
        right[i] = left[i]
    return -1.0 / value, 1.0 / (value * value)


@numba.njit(cache=True, nogil=True, error_model="numpy")
def figure_gradient(
    kind: int, links: Links, armature: Array, q: Array, mbar: Array, by_angle: Array, by_armature: Array
) -> float:
    """A figure at one configuration, with its derivatives by the angles and by the armature, each of shape (n,).

    Where the extreme eigenvalue is multiple the figure has a kink, and one of its subgradients is given.
    """
    n = q.shape[0]
    placed = scratch(links.parent.size)
    mass, left, right = np.empty((n, n)), np.empty(n), np.empty(n)
    fill_mass(links, armature, q, placed, mass)
    value, weight = extreme(kind, mass, mbar, left, right)
    bilinear_gradient(links, placed, left, right, np.empty((2, links.parent.size, 12)), by_angle)
    for i in range(n):
        by_angle[i] *= weight
        by_armature[i] = weight * left[i] * right[i]
    return value
