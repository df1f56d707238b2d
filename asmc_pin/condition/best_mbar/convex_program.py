"""The convex program behind the design of M̄: linear matrix inequalities at finitely many configurations.

With D = diag(m̄) and inertia matrices M_j, all of these are linear in (γ, μ, D):

- Lemma 1 at the level γ, ‖I − M_j⁻¹D‖₂ ≤ γ:  [[γI, I − M_j⁻¹D], [·, γI]] ⪰ 0;
- the weighted condition at the level γ:  (1 − γ) M_j ⪯ D ⪯ (1 + γ) M_j;
- λ_min(M_j⁻¹D) ≥ μ:  D ⪰ μ M_j.

What is found on a few configurations bounds from below what any M̄ can reach on all of them: rigorously so with the
bound that `dual_bound` derives from the multipliers.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin._typing import Array, IntArray
from asmc_pin.condition.best_mbar.dual_bound import dual_bound
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

    def of(self, joints: IntArray) -> Bounds:
        """Those of some joints."""
        return Bounds(self.lower[joints], self.upper[joints], self.form)


@dataclass(frozen=True, eq=False)
class Solution:
    """An optimum over finitely many configurations.

    Attributes:
        value: γ where that is minimised, μ where that is maximised, as the solver has it.
        bound: No M̄ has a smaller norm on these configurations, whatever the solver did; 0 where μ is maximised.
        mbar: Shape (nv,), kg·m².
        weights: Trace of each configuration's multiplier, shape (configurations,): 0 where it does not limit.
        by_armature: Derivative of `value` by each joint's armature, all configurations together, shape (nv,),
            1/(kg·m²).
    """

    value: float
    bound: float
    mbar: Array
    weights: Array
    by_armature: Array


def contraction_program(masses: Array, condition: Condition, bounds: Bounds, seconds: float = np.inf) -> Solution:
    """The M̄ of least norm on some configurations; where the solver fails, a cautious one and the bound 0.

    Args:
        masses: M_j, shape (configurations, nv, nv), kg·m².
        condition: ``lemma1`` or ``weighted``.
        bounds: What M̄ may be.
        seconds: Time for the solver, s.
    """
    scaled = _Scaled(masses, bounds)
    found = _solve(scaled, condition, None, seconds)
    if found is None:
        # Σᵢ xᵢ = 1 in these units: λ_max(M⁻¹M̄) ≤ 1, and the weighted condition holds if no bound forbids.
        share = np.full(scaled.nv, 1.0 / scaled.nv)
        return Solution(1.0, 0.0, scaled.mbar(share), np.zeros(len(masses)), np.zeros(scaled.nv))
    value, share, duals = found
    weights, slope = scaled.explained(condition, None, value, share, duals)
    ends = _ends(bounds)
    ceiling = max(1.0, 2.0 * value)
    bound = dual_bound(masses, scaled.roots, duals, condition, ends, bounds.form == "scalar", ceiling)
    return Solution(value, bound, scaled.mbar(share), weights, slope)


def bandwidth_program(
    masses: Array, condition: Condition, bounds: Bounds, level: float, seconds: float = np.inf
) -> Solution | None:
    """The M̄ of largest λ_min(M⁻¹M̄) on some configurations with a norm of at most `level`; None where none was found.

    Args:
        masses: M_j, shape (configurations, nv, nv), kg·m².
        condition: ``lemma1`` or ``weighted``.
        bounds: What M̄ may be.
        level: Largest norm allowed.
        seconds: Time for the solver, s.
    """
    scaled = _Scaled(masses, bounds)
    found = _solve(scaled, condition, level, seconds)
    if found is None:
        return None
    value, share, duals = found
    weights, slope = scaled.explained(condition, level, value, share, duals)
    return Solution(value, 0.0, scaled.mbar(share), weights, -slope)


class _Scaled:
    """Inertia matrices, in units in which m̄ᵢ is about 1, so that the solver's tolerances mean something."""

    def __init__(self, masses: Array, bounds: Bounds) -> None:
        self.masses, self.bounds, self.nv = masses, bounds, masses.shape[-1]
        self.roots = [_inverse_root(mass) for mass in masses]
        self.inverses = [root.T @ root for root in self.roots]
        unit = 1.0 / np.max([np.diag(inverse) for inverse in self.inverses], axis=0)
        self.unit = unit if bounds.form == "diagonal" else np.full(self.nv, unit.min())

    def mbar(self, share: Array) -> Array:
        """M̄ of a solution. The solver keeps bounds and equalities to its tolerance; M̄ keeps them exactly."""
        scalar = self.bounds.form == "scalar"
        values = np.full(self.nv, share.mean() * self.unit[0]) if scalar else share * self.unit
        return np.asarray(np.clip(values, *_ends(self.bounds)))

    def inequalities(self, j: int, condition: Condition, level: float | None) -> Sequence[tuple[Array, Array, Array]]:
        """Matrices (F₀, F_value, F_i) of the inequalities F₀ + F_value·value + Σ F_i·shareᵢ ⪰ 0 at configuration j."""
        return _inequalities(self.roots[j], self.unit, condition, level)

    def explained(
        self, condition: Condition, level: float | None, value: float, share: Array, duals: list[list[Array]]
    ) -> tuple[Array, Array]:
        """Traces of the multipliers; and how the optimum of the minimisation moves with armature (envelope theorem)."""
        slope = np.zeros(self.nv)
        gamma = value if level is None else level
        for root, inverse, mine in zip(self.roots, self.inverses, duals, strict=True):
            if condition == "lemma1":
                # ∂M⁻¹ = −M⁻¹eᵢeᵢᵀM⁻¹ in the block that is I − M⁻¹D.
                Q = mine[0][: self.nv, self.nv :]
                slope -= 2.0 * np.einsum("ai,ab,b,bi->i", inverse, Q, share * self.unit, inverse)
                rest = [(mine[1], -value)] if level is not None else []
            else:
                rest = [(mine[0], 1.0 + gamma), (mine[1], gamma - 1.0)]
                rest += [(mine[2], -value)] if level is not None else []
            # The others are of (factor · M ± D) between L⁻¹ and its transpose; by complementarity that is all.
            for dual, factor in rest:
                slope -= factor * np.einsum("ai,ab,bi->i", root, dual, root)
        return np.array([sum(float(np.trace(d)) for d in mine) for mine in duals]), slope


def _inverse_root(mass: Array) -> Array:
    """L⁻¹ with L Lᵀ = M, of eigenvectors where rounding leaves M no Cholesky factor."""
    try:
        return np.asarray(np.linalg.inv(np.linalg.cholesky(mass)))
    except np.linalg.LinAlgError:
        values, vectors = np.linalg.eigh(mass)
        values = np.maximum(values, np.finfo(np.float64).eps * values[-1])
        return np.asarray((vectors / np.sqrt(values)).T)


def _solve(
    scaled: _Scaled, condition: Condition, level: float | None, seconds: float
) -> tuple[float, Array, list[list[Array]]] | None:
    """The optimum, M̄ in the scaled units, and the multipliers of each configuration; None where there is none."""
    import cvxpy as cp

    nv, unit, bounds = scaled.nv, scaled.unit, scaled.bounds
    value, share = cp.Variable(), cp.Variable(nv)
    constraints: list[Any] = [share >= np.maximum(bounds.lower / unit, 1e-9)]
    if np.any(np.isfinite(bounds.upper)):
        capped = np.flatnonzero(np.isfinite(bounds.upper))
        constraints.append(share[capped] <= bounds.upper[capped] / unit[capped])
    if bounds.form == "scalar" and nv > 1:
        constraints.append(share[1:] == share[0])
    blocks: list[list[Any]] = []
    for j in range(len(scaled.masses)):
        blocks.append([])
        for constant, by_value, by_share in scaled.inequalities(j, condition, level):
            size = len(constant)
            flat = constant.ravel() + by_value.ravel() * value + by_share.reshape(nv, -1).T @ share
            blocks[-1].append(cp.reshape(flat, (size, size), order="C") >> 0)  # type: ignore[attr-defined]
    objective = cp.Minimize(value) if level is None else cp.Maximize(value)
    problem = cp.Problem(objective, constraints + [block for mine in blocks for block in mine])
    try:
        with warnings.catch_warnings():
            # An almost solved program is still useful: what its M̄ is worth is searched afterwards, not believed.
            warnings.filterwarnings("ignore", "Solution may be inaccurate", UserWarning)
            problem.solve(  # type: ignore[no-untyped-call]
                solver=cp.CLARABEL, time_limit=max(seconds, 1.0) if np.isfinite(seconds) else 1e9
            )
    except (cp.error.SolverError, ValueError, ArithmeticError):
        return None
    if problem.status not in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE, cp.USER_LIMIT) or value.value is None:
        return None
    duals = [[0.5 * (block.dual_value + block.dual_value.T) for block in mine] for mine in blocks]
    found = float(value.value), np.asarray(share.value), duals
    finite = np.isfinite(found[0]) and np.all(np.isfinite(found[1]))
    return found if finite and all(np.all(np.isfinite(d)) for mine in duals for d in mine) else None


def _ends(bounds: Bounds) -> tuple[Array, Array]:
    if bounds.form == "scalar":
        return np.full_like(bounds.lower, bounds.lower.max()), np.full_like(bounds.upper, bounds.upper.min())
    return bounds.lower, bounds.upper


def _inequalities(
    root: Array, unit: Array, condition: Condition, level: float | None
) -> Sequence[tuple[Array, Array, Array]]:
    nv = len(unit)
    eye, zero = np.eye(nv), np.zeros((nv, nv))
    # L⁻¹ diag(m̄) L⁻ᵀ = Σ m̄ᵢ wᵢ wᵢᵀ, wᵢ the columns of L⁻¹: has the eigenvalues of M⁻¹M̄.
    similar = np.einsum("ai,bi->iab", root, root) * unit[:, None, None]
    found: list[tuple[Array, Array, Array]] = []
    if condition == "lemma1":
        by_share = np.zeros((nv, 2 * nv, 2 * nv))
        inverse = root.T @ root
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
