"""A lower bound of what any M̄ can reach, from the multipliers of a solver that is not believed.

Let D = diag(m̄) have a norm γ < Γ on the inertia matrices M_j. Then D ≺ (1+Γ) M_j, so m̄ᵢ < (1+Γ)/(M_j⁻¹)ᵢᵢ: every m̄ᵢ has
two ends. For any Y ⪰ 0 the inequalities of `convex_program`, brought to a form without M⁻¹, give

- weighted, Y₁ for (1+γ)M − D ⪰ 0 and Y₂ for D − (1−γ)M ⪰ 0:  γ ⟨Y₁+Y₂, M⟩ ≥ ⟨Y₂−Y₁, M⟩ + Σ m̄ᵢ (Y₁−Y₂)ᵢᵢ;
- Lemma 1, Y = [[P, Q], [Qᵀ, R]] for [[γM², M−D], [M−D, γI]] ⪰ 0:  γ (⟨P, M²⟩ + tr R) ≥ 2 Σ m̄ᵢ Qᵢᵢ − 2⟨Q, M⟩,

summed over the configurations, with each m̄ᵢ at the end that makes the right side least. A multiplier is clipped to its
positive part by its eigenvalues and then *is* G Gᵀ for the factor G in floating point; all sums are evaluated from G
and M, with an allowance for rounding. So the bound rests on no optimality and no feasibility of what the solver gave.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.norm.two_conditions import Condition

ROUNDING = 1e-13
"""Share of all magnitudes that is taken off: some ten times what the sums and the inertia matrices round."""


def dual_bound(
    masses: Array,
    roots: Sequence[Array],
    duals: Sequence[Sequence[Array]],
    condition: Condition,
    ends: tuple[Array, Array],
    same: bool,
    ceiling: float,
) -> float:
    """A number that no M̄ within its ends can have a smaller norm than.

    Args:
        masses: M_j, shape (configurations, nv, nv), kg·m².
        roots: L⁻¹ of each, L Lᵀ = M; a bad one costs sharpness, never truth.
        duals: Multipliers of each configuration's inequalities, in `convex_program`'s form and order; any matrices.
        condition: ``lemma1`` or ``weighted``.
        ends: Least and largest m̄ᵢ, each (nv,), kg·m².
        same: Whether all m̄ᵢ are one.
        ceiling: Γ, the most that the bound can say.

    Returns:
        The bound, at least 0.
    """
    lower, upper = ends[0], np.minimum(ends[1], _largest(masses, roots, ceiling))
    if same:
        lower, upper = np.full_like(lower, lower.max()), np.full_like(upper, upper.min())
    if np.any(lower > upper):
        return ceiling
    constant, scale, allowed = 0.0, 0.0, 0.0
    slope, slope_size = np.zeros_like(lower), np.zeros_like(lower)
    for mass, root, mine in zip(masses, roots, duals, strict=True):
        size = np.abs(mass)
        if condition == "weighted":
            for dual, sign in zip(mine, (1.0, -1.0), strict=True):
                G = root.T @ _factor(dual)
                inner, most = float(np.sum(G * (mass @ G))), float(np.sum(np.abs(G) * (size @ np.abs(G))))
                scale, constant = scale + inner, constant - sign * inner
                allowed += most
                slope += sign * np.sum(G * G, axis=1)
                slope_size += np.sum(G * G, axis=1)
        else:
            half = _factor(mine[0])
            nv = len(mass)
            first, second = root.T @ (root @ half[:nv]), half[nv:]
            moved = mass @ first
            scale += float(np.sum(moved * moved) + np.sum(second * second))
            constant -= 2.0 * float(np.sum(moved * second))
            most = size @ np.abs(first)
            allowed += float(np.sum(most * most) + np.sum(second * second) + 2.0 * np.sum(most * np.abs(second)))
            slope += 2.0 * np.sum(first * second, axis=1)
            slope_size += 2.0 * np.sum(np.abs(first * second), axis=1)
    if same:
        slope, slope_size = np.array([slope.sum()]), np.array([slope_size.sum()])
        lower, upper = lower[:1], upper[:1]
    ends_of_slope = np.minimum(slope * lower, slope * upper) - ROUNDING * slope_size * np.maximum(lower, upper)
    least = constant + float(ends_of_slope.sum()) - ROUNDING * (allowed + float(np.abs(ends_of_slope).sum()))
    if not np.isfinite(least) or not least > 0.0:
        return 0.0
    return min(ceiling, least / (scale + ROUNDING * allowed) * (1.0 - ROUNDING))


def _factor(dual: Array) -> Array:
    """G with G Gᵀ near the positive part of a matrix."""
    if not np.all(np.isfinite(dual)):
        return np.zeros_like(dual)
    values, vectors = np.linalg.eigh(0.5 * (dual + dual.T))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def _largest(masses: Array, roots: Sequence[Array], ceiling: float) -> Array:
    """Upper ends of m̄ᵢ for a norm below the ceiling: (M⁻¹)ᵢᵢ ≥ 2vᵢ − vᵀMv for every v."""
    most = np.full(masses.shape[-1], np.inf)
    for mass, root in zip(masses, roots, strict=True):
        V = root.T @ root
        taken = ROUNDING * (np.sum(np.abs(V) * (np.abs(mass) @ np.abs(V)), axis=0) + 2.0 * np.abs(np.diag(V)))
        least = np.maximum(2.0 * np.diag(V) - np.sum(V * (mass @ V), axis=0) - taken, 0.5 / np.diag(mass))
        most = np.minimum(most, (1.0 + ceiling) / least * (1.0 + ROUNDING))
    return most
