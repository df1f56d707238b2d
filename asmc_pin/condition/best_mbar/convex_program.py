"""The convex program behind the design of M̄: linear matrix inequalities at finitely many configurations.

With D = diag(m̄) and inertia matrices M_j, all of these are linear in (γ, μ, D):

- Lemma 1 at the level γ, ‖I − M_j⁻¹D‖₂ ≤ γ:  [[γI, I − M_j⁻¹D], [·, γI]] ⪰ 0;
- the weighted condition at the level γ:  (1 − γ) M_j ⪯ D ⪯ (1 + γ) M_j;
- λ_min(M_j⁻¹D) ≥ μ:  D ⪰ μ M_j.

What is found on a few configurations bounds from below what any M̄ can reach on all of them.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.norm.two_conditions import Condition
from asmc_pin.words.choices import Form as Form


@dataclass(frozen=True, eq=False)
class Bounds:
    """What M̄ may be.

    Attributes:
        lower: Least m̄ᵢ, shape (nv,), kg·m²; 0 for none.
        upper: Largest m̄ᵢ, shape (nv,), kg·m²; ∞ for none.
        form: ``diagonal``: one value per joint. ``scalar``: one for all.
    """

    lower: Array
    upper: Array
    form: Form = "diagonal"


@dataclass(frozen=True, eq=False)
class Solution:
    """An optimum over finitely many configurations.

    Attributes:
        value: γ where that is minimised, μ where that is maximised.
        mbar: Shape (nv,), kg·m².
        weights: Trace of each configuration's multiplier, shape (configurations,): 0 where it does not limit.
        by_armature: Derivative of `value` by each joint's armature, all configurations together, shape (nv,),
            1/(kg·m²).
    """

    value: float
    mbar: Array
    weights: Array
    by_armature: Array


def contraction_program(masses: Array, condition: Condition, bounds: Bounds) -> Solution | None:
    """The M̄ of least norm on some configurations; None where the bounds leave none.

    Args:
        masses: M_j, shape (configurations, nv, nv), kg·m².
        condition: ``lemma1`` or ``weighted``.
        bounds: What M̄ may be.
    """
    return _solve(masses, condition, bounds, None)


def bandwidth_program(masses: Array, condition: Condition, bounds: Bounds, level: float) -> Solution | None:
    """The M̄ of largest λ_min(M⁻¹M̄) on some configurations with a norm of at most `level`; None where there is none.

    Args:
        masses: M_j, shape (configurations, nv, nv), kg·m².
        condition: ``lemma1`` or ``weighted``.
        bounds: What M̄ may be.
        level: Largest norm allowed.
    """
    return _solve(masses, condition, bounds, level)


def _solve(masses: Array, condition: Condition, bounds: Bounds, level: float | None) -> Solution | None:
    import cvxpy as cp

    nv = masses.shape[-1]
    inverse = np.linalg.inv(masses)
    # One unit per joint in which every entry of M̄ is about 1, so that the solver's tolerances mean something.
    unit = 1.0 / np.diagonal(inverse, axis1=1, axis2=2).max(axis=0)
    if bounds.form == "scalar":
        unit = np.full(nv, unit.min())
    value, share = cp.Variable(), cp.Variable(nv)
    constraints: list[Any] = [share >= np.maximum(bounds.lower / unit, 1e-9)]
    if np.any(np.isfinite(bounds.upper)):
        capped = np.flatnonzero(np.isfinite(bounds.upper))
        constraints.append(share[capped] <= bounds.upper[capped] / unit[capped])
    if bounds.form == "scalar" and nv > 1:
        constraints.append(share[1:] == share[0])
    blocks = []
    for mass in masses:
        for constant, by_value, by_share in _inequalities(mass, unit, condition, level):
            size = len(constant)
            flat = constant.ravel() + by_value.ravel() * value + by_share.reshape(nv, -1).T @ share
            blocks.append(cp.reshape(flat, (size, size), order="C") >> 0)  # type: ignore[attr-defined]
    problem = cp.Problem(cp.Minimize(value) if level is None else cp.Maximize(value), constraints + blocks)
    try:
        with warnings.catch_warnings():
            # An almost solved program is still useful: what its M̄ is worth is searched afterwards, not believed.
            warnings.filterwarnings("ignore", "Solution may be inaccurate", UserWarning)
            problem.solve(solver=cp.CLARABEL)  # type: ignore[no-untyped-call]
    except cp.error.SolverError:
        return None
    if problem.status not in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE) or value.value is None:
        return None
    duals = [0.5 * (block.dual_value + block.dual_value.T) for block in blocks]
    each = len(blocks) // len(masses)
    weights = np.array([sum(np.trace(d) for d in duals[i : i + each]) for i in range(0, len(duals), each)])
    x = float(value.value), np.asarray(share.value)
    slope = _by_armature(masses, unit, condition, level, x, duals)
    # The solver keeps bounds and equalities to its tolerance; M̄ keeps them exactly.
    mbar = np.clip(x[1] * unit if bounds.form == "diagonal" else np.full(nv, x[1].mean() * unit[0]), *_ends(bounds))
    return Solution(x[0], mbar, weights, slope if level is None else -slope)


def _ends(bounds: Bounds) -> tuple[Array, Array]:
    if bounds.form == "scalar":
        return np.full_like(bounds.lower, bounds.lower.max()), np.full_like(bounds.upper, bounds.upper.min())
    return bounds.lower, bounds.upper


def _inequalities(
    mass: Array, unit: Array, condition: Condition, level: float | None
) -> Sequence[tuple[Array, Array, Array]]:
    """Matrices (F₀, F_value, F_i) of the inequalities F₀ + F_value·value + Σ F_i·shareᵢ ⪰ 0 at one configuration."""
    nv = len(unit)
    eye, zero = np.eye(nv), np.zeros((nv, nv))
    root = np.linalg.inv(np.linalg.cholesky(mass))
    # L⁻¹ diag(m̄) L⁻ᵀ = Σ m̄ᵢ wᵢ wᵢᵀ, wᵢ the columns of L⁻¹: has the eigenvalues of M⁻¹M̄.
    similar = np.einsum("ai,bi->iab", root, root) * unit[:, None, None]
    found: list[tuple[Array, Array, Array]] = []
    if condition == "lemma1":
        by_share = np.zeros((nv, 2 * nv, 2 * nv))
        inverse = np.linalg.inv(mass)
        for i in range(nv):
            by_share[i, :nv, nv + i] = -inverse[:, i] * unit[i]
            by_share[i] += by_share[i].T
        off, diagonal = np.block([[zero, eye], [eye, zero]]), np.eye(2 * nv)
        found.append((off, diagonal, by_share) if level is None else (off + level * diagonal, 0 * diagonal, by_share))
    elif level is None:
        found += [(eye, eye, -similar), (-eye, eye, similar)]
    else:
        found += [((1.0 + level) * eye, zero, -similar), (-(1.0 - level) * eye, zero, similar)]
    if level is not None:
        found.append((zero, -eye, similar))
    return found


def _by_armature(
    masses: Array, unit: Array, condition: Condition, level: float | None, x: tuple[float, Array], duals: list[Array]
) -> Array:
    """Envelope theorem: how the optimum of the minimisation moves when armature is added to a joint."""
    nv = len(unit)
    slope = np.zeros(nv)
    each = len(duals) // len(masses)

    def at(mass: Array) -> list[Array]:
        parts = _inequalities(mass, unit, condition, level)
        return [f0 + f1 * x[0] + np.tensordot(x[1], f, axes=1) for f0, f1, f in parts]

    for j, mass in enumerate(masses):
        mine = duals[j * each : (j + 1) * each]
        if sum(np.trace(d) for d in mine) < 1e-7:
            continue
        inverse = np.linalg.inv(mass)
        for i in range(nv):
            # M − δ eᵢeᵢᵀ is positive definite for δ < 1/(M⁻¹)ᵢᵢ, which is far below M's own entry where M is near
            # singular.
            step = min(1e-6 * mass[i, i], 1e-3 / inverse[i, i])
            moved = mass.copy()
            moved[i, i] += step
            other = mass.copy()
            other[i, i] -= step
            for dual, up, down in zip(mine, at(moved), at(other), strict=True):
                slope[i] -= float(np.sum(dual * (up - down))) / (2.0 * step)
    return slope
