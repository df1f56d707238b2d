"""A statement about joints that mimic others, as one about joints that move freely: sufficient, and never more.

With q̇_tree = S q̇ a statement says Sᵀ X S ≻ 0, where X is the form of the links and diag(t) the joints' own forms. The
own form of a driven coordinate, t_c ẋ², may be shared out among the joints that follow it, t_c = Σ r_i² t_i, r_i their
ratios. Where the form of the whole tree with these t_i is positive for *all* joint velocities, it is so for those that
S allows; and for all joint values in the boxes that the coordinates' ranges come to, so for those that occur together.
Both lose something: a proof may stop below what holds, and a configuration where the form of the tree is not positive
refutes nothing.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.rigid_body.coupling import uncoupled
from asmc_pin.rigid_body.mass_matrix import mass_matrices

if TYPE_CHECKING:
    from asmc_pin.condition.certificate.statement import Statement
    from asmc_pin.condition.domain.joint_box import Box
    from asmc_pin.rigid_body.tree import Tree

_SAMPLES, _ROUNDS = 32, 80
_HALVINGS = 50
_LARGEST = 1e3
"""Of a share: their sum is rounded at their own size."""

_SAFE = 1e-14
"""Share of all that is borne that is added, so that the sums of rounded numbers are what they have to be."""

_ROUNDING = 1e-15
"""Share of its ends by which a follower's range is widened, for the products that it is made of."""


class Unfolded(NamedTuple):
    """A statement about the tree with every joint free; arrays of one entry per joint, shape (n,).

    Attributes:
        tree: Its joints follow nobody.
        lower: Where each is.
        upper: The same.
        mbar: m̄ of the coordinate that it follows, kg·m².
        statement: With armature and slack on the joints that are followed.
        share: Of the coordinate's m̄ that is its own, over the ratio squared.
        even: The same, shared out evenly, for velocities that no inertia belongs to.
    """

    tree: Tree
    lower: Array
    upper: Array
    mbar: Array
    statement: Statement
    share: Array
    even: Array


def unfold(tree: Tree, lower: Array, upper: Array, mbar: Array, statement: Statement) -> Unfolded:
    """Free every joint of a statement.

    Args:
        tree: The arm, some joints of which mimic others.
        lower: Box of its coordinates, shape (nv,).
        upper: The same.
        mbar: Diagonal of M̄, shape (nv,), kg·m².
        statement: What is to be proven.
    """
    coupling = tree.coupling
    coordinate, ratio, n = coupling.coordinate, coupling.ratio, tree.joints
    leads = np.zeros(n)
    leads[coupling.leader] = 1.0
    armature, slack = (leads * own[coordinate] for own in (statement.armature, statement.slack))
    free = replace(tree, armature=armature, coupling=uncoupled(n))
    ends = np.sort(np.stack([ratio * end[coordinate] + coupling.offset for end in (lower, upper)]), axis=0)
    wider = (1.0 - leads) * _ROUNDING * (np.abs(ratio) * np.maximum(np.abs(lower), np.abs(upper))[coordinate])
    wider = wider + (1.0 - leads) * _ROUNDING * np.abs(coupling.offset)
    q = lower + np.random.default_rng(0).random((_SAMPLES, tree.nv)) * (upper - lower)
    mass = mass_matrices(free, coupling.joints(q))
    if statement.kind == "bounded":
        weight = ratio**2 * np.diagonal(mass, axis1=1, axis2=2).max(axis=0)
        share = weight / np.bincount(coordinate, weight)[coordinate]
    else:
        share = _shares(mass, mbar[coordinate] / ratio**2, tree)
    even = _evenly(tree)
    own = replace(statement, armature=armature, slack=slack)
    return Unfolded(free, ends[0] - wider, ends[1] + wider, mbar[coordinate], own, share / ratio**2, even / ratio**2)


def weights_of(tree: Tree, mbar: Array, unfolded: Unfolded) -> Array:
    """What each joint bears of m̄, as a certificate states it, shape (n,): for sure not less than m̄ on what S allows.

    Of ``bounded`` not more. What is added is some hundred roundings, and far less than the margin of the proof.

    Args:
        tree: The arm, or a branch of it.
        mbar: Of its coordinates, shape (nv,), kg·m².
        unfolded: The statement that was proven.
    """
    coupling = tree.coupling
    borne = unfolded.mbar * unfolded.share
    size = np.bincount(coupling.coordinate, np.abs(coupling.ratio**2 * borne), tree.nv)
    weights = np.array(borne)
    sign = -1.0 if unfolded.statement.kind == "bounded" else 1.0
    weights[coupling.leader] += sign * _SAFE * (size + mbar)
    return weights


def halved(tree: Tree, whole: Box, piece: tuple[Array, Array]) -> list[tuple[Array, Array]]:
    """Both halves of a box of coordinates, cut where it is widest against the whole; those that joints follow first.

    Args:
        tree: The arm.
        whole: The box that it is a part of.
        piece: Its ends, each (nv,).

    Returns:
        The halves; nothing where no coordinate matters, or it was halved as often as any is.
    """
    lower, upper = piece
    followed = np.bincount(tree.coupling.coordinate, minlength=tree.nv) > 1
    wide = np.where(whole.free, (upper - lower) / np.maximum(whole.upper - whole.lower, 1e-300), 0.0)
    at = int(np.argmax(wide * np.where(followed, 2.0, 1.0)))
    middle = 0.5 * (lower[at] + upper[at])
    if not lower[at] < middle < upper[at] or wide[at] < 0.5**_HALVINGS:
        return []
    ends, begins = upper.copy(), lower.copy()
    ends[at], begins[at] = middle, middle
    return [(lower, ends), (begins, upper)]


def _shares(mass: Array, weight: Array, tree: Tree) -> Array:
    """Shares σ of each coordinate with a small largest eigenvalue of M⁻¹ diag(weight σ) over some configurations.

    Coordinate by coordinate, as if the others' m̄ were nothing. It is convex in σ, whose sum is 1; a share may be
    negative: what helps one motion of a parallelogram, its follower's, is taken from the other.
    """
    coordinate = tree.coupling.coordinate
    share = np.ones(tree.joints)
    try:
        compliance = np.linalg.inv(mass)
        for number in np.flatnonzero(np.bincount(coordinate) > 1):
            joints = np.flatnonzero(coordinate == number)
            root = np.linalg.cholesky(compliance[:, joints[:, None], joints])
            share[joints] = _shared_out(root, weight[joints], compliance[0, joints, joints])
    except np.linalg.LinAlgError:  # a joint moves nothing of its own: nothing will be proven
        return _evenly(tree)
    return share


def _shared_out(root: Array, weight: Array, first: Array) -> Array:
    """The shares of one coordinate's joints, shape (k,); `root` of their compliances, (samples, k, k)."""
    from scipy.optimize import minimize

    # In units in which every joint alone would bear as much at the first configuration.
    scale = 1.0 / (weight * first)
    scale = scale / scale.sum()
    begin = np.ones(weight.size - 1)
    simplex = np.vstack([begin, begin + 0.5 * np.eye(begin.size)])

    def shares(free: Array) -> Array:
        own = scale[:-1] * free
        return np.append(own, 1.0 - own.sum())

    def most(free: Array) -> float:
        form = root.swapaxes(1, 2) @ ((weight * shares(free))[:, None] * root)
        return float(np.linalg.eigvalsh(form)[:, -1].max())

    result = minimize(
        most,
        begin,
        method="Nelder-Mead",
        options={"maxiter": _ROUNDS * begin.size, "initial_simplex": simplex, "xatol": 1e-4, "fatol": 1e-4},
    )
    found = shares(result.x)
    return found if np.abs(found).max() < _LARGEST else shares(begin)


def _evenly(tree: Tree) -> Array:
    coordinate = tree.coupling.coordinate
    return np.asarray(1.0 / np.bincount(coordinate)[coordinate])
