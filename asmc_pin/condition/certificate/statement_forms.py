"""Statements about an arm, and the form in which the compiled proof takes them.

Each statement says that a quadratic form is positive for every q of a box. With N = M̄⁻¹ and s = √(1 − γ²)

    weighted   M − f/(1+γ) M̄                                 M̄ ≺ (1+γ) M / f: the condition itself at γ = 1
    bounded    f/(1−γ) M̄ − M                                 (1−γ) M ≺ f M̄: the other half of a level γ < 1
    lemma1     N M + M N − f I                                ‖I − f M⁻¹M̄‖₂ < 1
    level      [[N M + M N − f I, s M N], [s N M, f I]]       ‖I − f M⁻¹M̄‖₂ < γ   (up to a congruence by f)

The last two are written as forms of two twists per link, v = J x and w = J N (x + s y) (certificate.md, Lift).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.compiled.working_state import Problem
from asmc_pin.condition.certificate.mimic_shares import Unfolded, unfold
from asmc_pin.condition.certificate.statement import Statement

if TYPE_CHECKING:
    from asmc_pin.rigid_body.tree import Tree

SPREAD = 0.05
"""Share of the rigid metric in the metric of losses; from 0.01 to 1 the number of boxes changes by a factor of two."""

MARGIN = 1e-9
"""The proof is of f (1 + this) in place of f, so that what is proven is strict."""

DATA = 1e-13
"""Share of each body's largest possible inertia that is taken off for the last digits of the arm's data: some hundred
times what turning frames and weighing by M̄ round."""


def canonical(tree: Tree) -> tuple[Array, Array]:
    """Joint frames turned so that z is the axis: motion transforms at q = 0 and spatial inertias, each (nv, 6, 6)."""
    n = tree.nv
    turned = np.empty((n, 3, 3))
    place, rigid = np.zeros((n, 6, 6)), np.zeros((n, 6, 6))
    for i in range(n):
        z = tree.axis[i] / np.linalg.norm(tree.axis[i])
        x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
        x /= np.linalg.norm(x)
        turned[i] = np.column_stack((x, np.cross(z, x), z))
        rotation, translation = tree.rotation[i] @ turned[i], tree.translation[i]
        if tree.parent[i] >= 0:
            base = turned[tree.parent[i]]
            rotation, translation = base.T @ rotation, base.T @ translation
        place[i, :3, :3] = place[i, 3:, 3:] = rotation.T
        place[i, 3:, :3] = -rotation.T @ _cross(translation)
        com = turned[i].T @ tree.com[i]
        about = turned[i].T @ tree.inertia[i] @ turned[i]
        lever = tree.mass[i] * _cross(com)
        rigid[i, :3, :3] = 0.5 * (about + about.T) - lever @ _cross(com)
        rigid[i, :3, 3:], rigid[i, 3:, :3] = lever, lever.T
        rigid[i, 3:, 3:] = tree.mass[i] * np.eye(3)
    return place, rigid


def problem_of(tree: Tree, lower: Array, upper: Array, mbar: Array, statement: Statement) -> Problem:
    """A statement in compiled form; where joints mimic others, one that is sufficient for it (`mimic_shares`).

    Args:
        tree: The arm; its own armature is not used.
        lower: Joint box, shape (nv,).
        upper: The same.
        mbar: Diagonal of M̄, shape (nv,), kg·m².
        statement: What is to be proven.

    Returns:
        The problem; its arrays are its own.
    """
    return problem_of_unfolded(freed(tree, lower, upper, mbar, statement))


def freed(tree: Tree, lower: Array, upper: Array, mbar: Array, statement: Statement) -> Unfolded:
    """A statement about joints that all move freely; the same one where none mimics another."""
    if tree.coupling.follows:
        return unfold(tree, lower, upper, mbar, statement)
    alike = np.ones(tree.joints)
    return Unfolded(tree, lower, upper, mbar, statement, alike, alike)


def problem_of_unfolded(unfolded: Unfolded) -> Problem:
    """The same of a statement about joints that all move freely."""
    tree, lower, upper, mbar, statement, share, even = unfolded
    n = tree.nv
    place, rigid = canonical(tree)
    f = statement.scale * (1.0 + MARGIN)
    gamma, armature, slack = statement.level, statement.armature, statement.slack
    if statement.kind == "weighted":
        link, motion = rigid.copy(), np.ones((n, 1, 1))
        joint = (armature - f / (1.0 + gamma) * mbar * share)[:, None, None]
    elif statement.kind == "bounded":
        link, motion = -rigid, np.ones((n, 1, 1))
        joint = (statement.scale * (1.0 - MARGIN) / (1.0 - gamma) * mbar * share - armature - slack)[:, None, None]
    else:
        # Joint velocities in units of M̄^(-1/2), and the two twists brought to one size.
        middle = np.sqrt(mbar.min() * mbar.max())
        v, w = np.sqrt(mbar / middle), np.sqrt(middle / mbar)
        link = np.zeros((n, 12, 12))
        link[:, :6, 6:] = link[:, 6:, :6] = rigid
        if statement.kind == "lemma1":
            motion = np.stack((v, w), axis=1)[:, :, None]
            joint = (2.0 * armature - f * mbar * share)[:, None, None]
        else:
            s = np.sqrt((1.0 - gamma) * (1.0 + gamma))
            motion = np.zeros((n, 2, 2))
            motion[:, 0, 0], motion[:, 1, 0], motion[:, 1, 1] = v, w, s * w
            joint = np.zeros((n, 2, 2))
            joint[:, 0, 0] = 2.0 * armature - f * mbar * share
            joint[:, 1, 1] = statement.scale * (1.0 - MARGIN) * mbar * even
            joint[:, 0, 1] = joint[:, 1, 0] = s * armature
            # a [[2, s], [s, 0]], a in [0, slack], is at least slack times its negative part, 1 − √(1 + s²).
            values, vectors = np.linalg.eigh(np.array([[2.0, s], [s, 0.0]]))
            joint -= (
                slack[:, None, None] * max(-values[0], 0.0) * np.outer(vectors[:, 0], vectors[:, 0]) * (1.0 + MARGIN)
            )
    pairing = np.ones((1, 1)) if motion.shape[1] == 1 else np.array([[0.0, 1.0], [1.0, 0.0]])
    largest = np.sqrt(_largest(tree, lower, upper))
    weights = np.einsum("ipk,pr,jrl,i,j->ikjl", np.abs(motion), pairing, np.abs(motion), largest, largest)
    e = motion.shape[2]
    joint[:, range(e), range(e)] -= DATA * weights.sum(axis=(2, 3))
    exact = bool(n > 1 and tree.parent[1] == 0 and not tree.prismatic[1])
    return Problem(
        np.array(tree.parent),
        np.array(tree.prismatic),
        place,
        rigid,
        np.ascontiguousarray(link),
        np.ascontiguousarray(motion),
        np.ascontiguousarray(joint),
        np.array(lower, dtype=np.float64),
        np.array(upper, dtype=np.float64),
        exact,
        SPREAD,
    )


def _largest(tree: Tree, lower: Array, upper: Array) -> Array:
    """A bound of the diagonal of M(q) over the box, armature left out, shape (nv,): everything stretched out."""
    offset = np.linalg.norm(tree.translation, axis=1)
    offset += np.where(tree.prismatic, np.maximum(np.abs(lower), np.abs(upper)), 0.0)
    bound = np.zeros(tree.nv)
    for k in range(tree.nv):
        reach, i = float(np.linalg.norm(tree.com[k])), k
        # What stands for a range of places may be no body's, and have moments of either sign.
        own = float(max(np.trace(tree.inertia[k]), np.linalg.norm(tree.inertia[k])))
        while i >= 0:
            bound[i] += tree.mass[k] if tree.prismatic[i] else own + tree.mass[k] * reach**2
            reach += float(offset[i])
            i = int(tree.parent[i])
    return bound


def _cross(v: Array) -> Array:
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
