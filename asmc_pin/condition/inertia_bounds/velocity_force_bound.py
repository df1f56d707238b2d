"""A bound c of the velocity forces, ‖S C(q, Sx) Sx‖ ≤ c ‖x‖² over a joint box; the proof is in docs/bounds.md.

From masses, second moments and reaches alone: no configuration is looked at. `checker.balls.velocity_forces` has the
same bound in ball arithmetic.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array, BoolArray

if TYPE_CHECKING:
    from asmc_pin.rigid_body.tree import Tree

_ROUNDING = 1e-9
"""Share by which the result is raised. It is made of sums of what is not negative, but for a body's lever about its own
joint, so a few hundred operations lose less than 1e-13 of it; what the lever loses is far below `_LACK`."""

_LACK, _LEAST_LACK = 2e-12, 1e-25
"""By this share of a body's second moments, and this many kg·m², they are taken to fall short of being positive."""


def velocity_force_bound(tree: Tree, lower: Array, upper: Array, scaling: Array, largest: float | None) -> float:
    """The bound c of an arm over a joint box.

    Args:
        tree: The arm; its armature does not matter.
        lower: Joint box, shape (nv,).
        upper: The same.
        scaling: Diagonal of S, shape (nv,).
        largest: A bound of the eigenvalues of S M S over the box; None where none is proven.

    Returns:
        c, in kg·m² where S is the unit matrix.
    """
    before = _on_the_way(tree)
    size, lack = _second_moments(tree, lower, upper, before)
    if largest is not None:
        beyond = before @ lack
        # M_kk of the rigid links is below that of M, which has the armature besides.
        size = np.minimum(size, ((largest / scaling**2) + 6.0 * beyond)[:, None])
    root = np.sqrt(size) * scaling[:, None]
    tensor = _tensor(tree, root, scaling, before)
    flat = tensor.reshape(tree.nv, -1)
    found = float(np.sqrt(_largest_eigenvalue(flat @ flat.T)))
    if largest is not None:
        middle = np.zeros((tree.nv, tree.nv))
        for k in range(tree.nv):
            for j in np.flatnonzero(before[:, k] & ~tree.prismatic):
                middle[j, k] = middle[k, j] = scaling[j] * root[k, k]
        energy = largest + 6.0 * tree.nv * float(lack.sum() * np.max(scaling) ** 2)
        found = min(found, float(np.sqrt(energy)) * _largest_eigenvalue(middle))
    return found * (1.0 + _ROUNDING)


def _on_the_way(tree: Tree) -> BoolArray:
    """Whether joint j is k or on the way from the base to it, [j, k]."""
    found = np.eye(tree.nv, dtype=np.bool_)
    for k in range(tree.nv):
        if tree.parent[k] >= 0:
            found[:, k] |= found[:, tree.parent[k]]
    return found


def _second_moments(tree: Tree, lower: Array, upper: Array, before: BoolArray) -> tuple[Array, Array]:
    """Bounds of ∫|∂p/∂q_k|² dm over all that lies beyond joint t, [k, t], and what each body's moments lack, (nv,)."""
    n = tree.nv
    slide = np.where(tree.prismatic, np.maximum(np.abs(lower), np.abs(upper)), 0.0)
    size, lacking = np.zeros((n, n)), np.zeros(n)
    for b in range(n):
        mass, spread = float(tree.mass[b]), 0.5 * float(np.trace(tree.inertia[b]))
        moments = spread * np.eye(3) - tree.inertia[b]
        lacking[b] = max(0.0, -float(np.linalg.eigvalsh(moments)[0])) + _LACK * spread + _LEAST_LACK
        share = np.zeros(n)
        k, after, reach = b, -1, float(np.linalg.norm(tree.com[b]))
        while k >= 0:
            axis = tree.axis[k]
            if tree.prismatic[k]:
                share[k] = mass
            elif k == b:
                share[k] = mass * np.sum(np.cross(axis, tree.com[b]) ** 2) + axis @ tree.inertia[b] @ axis
            else:
                away = float(np.linalg.norm(np.cross(axis, tree.translation[after]))) + float(slide[after])
                share[k] = mass * (away + reach) ** 2 + spread
            share[k] += 6.0 * lacking[b]
            if k != b:
                reach += float(np.linalg.norm(tree.translation[after]) + slide[after])
            k, after = int(tree.parent[k]), k
        # The body lies beyond t, and k on the way to t.
        size += np.where(before & before[:, b][None, :], share[:, None], 0.0)
    return size, lacking


def _tensor(tree: Tree, root: Array, scaling: Array, before: BoolArray) -> Array:
    """Bounds of |s_i s_j s_k Γ_ijk|, shape (nv, nv, nv)."""
    n = tree.nv
    found = np.zeros((n, n, n))
    for k in range(n):
        for j in np.flatnonzero(before[:, k] & ~tree.prismatic):
            for i in range(n):
                if i != k and (before[i, k] or before[k, i]):
                    top = k if before[i, k] else i
                    found[i, j, k] = found[i, k, j] = root[i, top] * root[k, top] * scaling[j]
    return found


def _largest_eigenvalue(matrix: Array) -> float:
    """At least the largest eigenvalue of a symmetric matrix without negative entries (Collatz and Wielandt)."""
    v = np.ones(len(matrix))
    for _ in range(100):
        v = matrix @ v + 1e-9 * v.max()
        v /= v.max()
    return float(np.max((matrix @ v) / v)) if v.min() > 0.0 else float(matrix.sum())
