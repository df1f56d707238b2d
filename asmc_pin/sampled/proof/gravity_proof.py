"""A proof that gravity at rest does not make the frozen plain loop unstable: small gain, by quadratic forms of a mode.

Gravity is a spring Γ = M̄^(−½) G M̄^(−½) about rest, and ‖Γ‖ ≤ g from masses and reaches. Each mode of the loop without
gravity, with eigenvalue a of M⁻¹M̄, answers to it with a gain below 1/g where a 3 × 3 form P decreases fast enough; the
inequality is convex in a, so that one P serves a whole piece of the range of a if it does at the piece's two ends.
docs/stability.md has the proof; the checker tests the same P in ball arithmetic.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array

if TYPE_CHECKING:
    from asmc_pin.rigid_body.tree import Tree

_ROUNDING = 1e-9
_MARGIN = 1e-8
"""Least eigenvalue that an inequality must have left, in units of its diagonal."""

_HELD = np.array([[1.0 / 3.0, 0.5], [0.5, 1.0]])
"""Largest ∫(1−t)w and ∫w of an input w over a period of 1: they lie in the ellipse of this matrix times ∫w²."""

_SPAN = np.array([[1.0, 1.0 / 2.0, 1.0 / 6.0], [1.0 / 2.0, 1.0 / 3.0, 1.0 / 8.0], [1.0 / 6.0, 1.0 / 8.0, 1.0 / 20.0]])
"""∫ over a period of products of 1, t and t²/2."""

_EXTRA = (1.0, 0.1, 0.01, 0.0)
_NARROWEST, _MOST_PIECES, _DOUBLINGS = 1.0 + 1e-4, 500, 60


@dataclass(frozen=True, eq=False)
class GravityForms:
    """Quadratic forms that prove it, piece by piece of the eigenvalues of M⁻¹M̄.

    Attributes:
        ends: Of the pieces, ascending, shape (pieces + 1,).
        forms: P of each piece, for the state (ξ, Lξ̇, L²(ū − q̈̂)) of a mode, shape (pieces, 3, 3).
    """

    ends: Array
    forms: Array


def stiffness_bound(tree: Tree, lower: Array, upper: Array, mbar: Array, magnitude: float) -> float:
    """A bound of ‖M̄^(−½) G(q) M̄^(−½)‖ over a joint box, G = ∂g/∂q, for gravity of any direction.

    Args:
        tree: The arm.
        lower: Joint box, shape (nv,).
        upper: The same.
        mbar: Diagonal of M̄, shape (nv,), kg·m².
        magnitude: Acceleration of gravity, m/s².

    Returns:
        1/s².
    """
    n = tree.nv
    slide = np.where(tree.prismatic, np.maximum(np.abs(lower), np.abs(upper)), 0.0)
    moment = np.zeros(n)  # of what lies beyond joint k about its axis, kg·m; or its mass
    for b in range(n):
        own = tree.mass[b] * tree.com[b]
        k, after, reach = b, -1, 0.0
        while k >= 0:
            axis = tree.axis[k]
            if tree.prismatic[k]:
                moment[k] += tree.mass[b]
            elif k == b:
                moment[k] += np.linalg.norm(np.cross(axis, own)) + _ROUNDING * np.linalg.norm(own)
            else:
                away = float(np.linalg.norm(np.cross(axis, tree.translation[after]))) + slide[after]
                moment[k] += tree.mass[b] * (away + reach) + np.linalg.norm(own)
            if k != b:
                reach += float(np.linalg.norm(tree.translation[after])) + slide[after]
            k, after = int(tree.parent[k]), k
    stiffness = np.zeros((n, n))
    for k in range(n):
        j = k
        while j >= 0:
            if not tree.prismatic[j]:
                stiffness[j, k] = stiffness[k, j] = magnitude * moment[k]
            j = int(tree.parent[j])
    scaled = stiffness / np.sqrt(mbar) / np.sqrt(mbar)[:, None]
    v = np.ones(n)
    for _ in range(100):
        v = scaled @ v + 1e-9 * max(v.max(), 1e-300)
        v /= v.max()
    return float(np.max(scaled @ v / v)) * (1.0 + _ROUNDING)


def pieces_of(ks: float, beta: float, period: float, stiffness: float, low: float, high: float) -> GravityForms | None:
    """Forms for every eigenvalue from low to high, where the small gain suffices; else None.

    Args:
        ks: k_s, 1/s.
        beta: β, 1/s.
        period: L, s.
        stiffness: g, 1/s².
        low: Least eigenvalue of M⁻¹M̄, positive.
        high: Largest.
    """
    spring = stiffness * period**2
    if not 0.0 < spring * high < 2.0 or not 0.0 < low < high:
        return None
    gain = (1.0 - 0.5 * spring * high) / spring * (1.0 - _ROUNDING)
    damping, square = (ks + beta) * period, ks * beta * period**2
    waiting = [(low, high)]
    ends, forms = [low], []
    while waiting:
        first, last = waiting.pop()
        middle = float(np.sqrt(first * last))
        form = _form(first, middle, last, damping, square, gain)
        if form is not None:
            ends.append(last)
            forms.append(form)
        elif last < first * _NARROWEST or len(forms) + len(waiting) > _MOST_PIECES:
            return None
        else:
            waiting += [(middle, last), (first, middle)]
    return GravityForms(np.array(ends), np.array(forms))


def _form(first: float, middle: float, last: float, damping: float, square: float, gain: float) -> Array | None:
    """A form of the middle's mode that decreases enough at both ends too."""
    for extra in _EXTRA:
        form = _solution(middle, damping, square, gain, extra)
        if form is not None and _is_positive(form):
            at_ends = (-_change(form, a, damping, square, gain) for a in (first, last))
            if all(_is_positive(matrix) for matrix in at_ends):
                return form
    return None


def _mode(a: float, damping: float, square: float) -> tuple[Array, Array, Array]:
    """A period of the mode: its map, what ∫(1−t)w and ∫w add, and its motion within, as factors of 1, t and t²/2."""
    command = np.array([-square, -damping, 1.0])
    step = np.array([[1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    step += np.outer([0.5 * a, a, 1.0 - a], command)
    return step, np.array([[a, 0.0], [0.0, a], [0.0, -a]]), np.stack(([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], a * command))


def _change(form: Array, a: float, damping: float, square: float, gain: float) -> Array:
    """zᵀPz after a period less before it, plus ∫ of the motion's square, less gain² ∫w²: must be negative definite."""
    step, push, motion = _mode(a, damping, square)
    both = np.hstack((step, push))
    found = both.T @ form @ both
    found[:3, :3] += motion.T @ _SPAN @ motion - form
    found[3:, 3:] -= gain**2 * np.linalg.inv(_HELD)
    return np.asarray(found)


def _solution(a: float, damping: float, square: float, gain: float, extra: float) -> Array | None:
    """P with equality in the inequality, and something to spare, by structured doubling; None where there is none."""
    step, push, motion = _mode(a, damping, square)
    form = motion.T @ _SPAN @ motion + extra * np.diag([1.0, 1.0 / damping**2, 1.0 / damping**2])
    inputs = -push @ _HELD @ push.T / gain**2
    with np.errstate(all="ignore"):
        for _ in range(_DOUBLINGS):
            try:
                inner = np.linalg.inv(np.eye(3) + inputs @ form)
            except np.linalg.LinAlgError:
                return None
            grown = form + step.T @ form @ inner @ step
            inputs, step = inputs + step @ inner @ inputs @ step.T, step @ inner @ step
            if not np.all(np.isfinite(grown)):
                return None
            still = np.abs(grown - form).max() <= 1e-14 * np.abs(grown).max()
            form = grown
            if still:
                return np.asarray(0.5 * (form + form.T))
    return None


def _is_positive(matrix: Array) -> bool:
    diagonal = np.diag(matrix)
    if not np.all(np.isfinite(matrix)) or np.any(diagonal <= 0.0):
        return False
    scale = 1.0 / np.sqrt(diagonal)
    return bool(np.linalg.eigvalsh(matrix * scale * scale[:, None])[0] > _MARGIN)
