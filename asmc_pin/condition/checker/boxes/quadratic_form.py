"""A statement of a certificate as a quadratic form, and what each joint can do in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array, IntArray
from asmc_pin.condition.checker.reading.header_parts import WrittenStatement
from asmc_pin.condition.checker.reading.link_chain import Chain

SLACKER = 1e-15
"""Share of armature and slack by which the slack is replayed larger, so that the rounding of a range is inside."""

_TURN = 2.0 * np.pi * (1.0 + 1e-9)
_SHARE = 0.05
_LIFT = 0.03


@dataclass(frozen=True, eq=False)
class Form:
    """The statement: Σ over bodies of (twists)ᵀ (pairing ⊗ inertia) (twists) + Σ over joints of xᵀ own x > 0.

    Attributes:
        chain: The arm.
        pairing: How the p twists of a body enter, shape (p, p).
        mixing: How the e velocities of a joint enter the p twists, shape (n, p, e).
        own: Shape (n, e, e).
        own_size: Row sums of the magnitudes that took part in `own`, which may be far above what is left, (n, e).
        exact: Whether joint 1 is followed over `range_1` and not cut into cells.
        range_1: Its range, rad.
        lower: Of the whole box, shape (n,).
        upper: The same.
    """

    chain: Chain
    pairing: Array
    mixing: Array
    own: Array
    own_size: Array
    exact: bool
    range_1: tuple[float, float]
    lower: Array
    upper: Array

    def columns(self, i: int) -> Array:
        """Twists of joint i's body per unit of its velocities, shape (6p, e)."""
        return np.kron(self.mixing[i], self.chain.subspace[i][:, None])

    def body(self, i: int) -> Array:
        """Form of body i, shape (6p, 6p)."""
        return np.kron(self.pairing, self.chain.inertia[i])

    def branch(self, joints: IntArray) -> Form:
        """The form of the joints of one branch that hangs on the base, which no other branch enters."""
        if joints.size == self.chain.parent.size:
            return self
        chain = self.chain
        number = {int(joint): k for k, joint in enumerate(joints)} | {-1: -1}
        own = Chain(
            np.array([number[int(parent)] for parent in chain.parent[joints]]),
            chain.place[joints],
            chain.axis[joints],
            chain.slides[joints],
            chain.inertia[joints],
        )
        lower, upper = self.lower[joints], self.upper[joints]
        exact, range_1 = _followed(own, lower, upper)
        mixing, diagonal, size = self.mixing[joints], self.own[joints], self.own_size[joints]
        return Form(own, self.pairing, mixing, diagonal, size, exact, range_1, lower, upper)

    def lift(self, X: Array) -> Array:
        """Block-diagonal motion transform of p twists, (..., 6p, 6p)."""
        return lift(X, self.pairing.shape[0])


def lift(X: Array, p: int) -> Array:
    """diag(X, …, X), p times."""
    if p == 1:
        return X
    out = np.zeros((*X.shape[:-2], 12, 12))
    out[..., :6, :6] = out[..., 6:, 6:] = X
    return out


@dataclass(frozen=True, eq=False)
class Borne:
    """What each joint of a form has to do with M̄ and the armature, each shape (n,), kg·m² (kg).

    Attributes:
        mbar: m̄ of the coordinate that it follows, in N.
        armature: Its own.
        slack: Range of the armature beyond that.
        most: What is borne of m̄ where the form falls with it.
        least: The same where the form grows with it.
    """

    mbar: Array
    armature: Array
    slack: Array
    most: Array
    least: Array


def form_of(chain: Chain, mbar: Array, statement: WrittenStatement, lower: Array, upper: Array) -> Form:
    """A statement of a certificate as a quadratic form, of joints that move freely."""
    own = Borne(mbar, np.array(statement.armature), np.array(statement.slack), mbar, mbar)
    return form_with(chain, own, statement, lower, upper)


def form_with(chain: Chain, borne: Borne, statement: WrittenStatement, lower: Array, upper: Array) -> Form:
    """The same with another part of m̄ at each joint."""
    mbar, armature, slack = borne.mbar, borne.armature, borne.slack
    n = mbar.size
    f, gamma, kind = statement.scale, statement.level, statement.kind
    if slack.any():
        slack = slack + SLACKER * (armature + slack)
    root = np.sqrt(mbar)
    if kind in ("weighted", "bounded"):
        pairing, mixing = np.array([[1.0 if kind == "weighted" else -1.0]]), np.ones((n, 1, 1))
        share = f * borne.most / (1.0 + gamma) if kind == "weighted" else f * borne.least / (1.0 - gamma)
        own = (armature - share if kind == "weighted" else share - armature - slack)[:, None, None]
        own_size = (np.abs(share) + armature + slack)[:, None]
    else:
        pairing, middle = np.array([[0.0, 1.0], [1.0, 0.0]]), float(np.exp(np.log(root).mean()))
        mixing = np.stack((root / middle, middle / root), axis=1)[:, :, None]
        own = (2.0 * armature - f * borne.most)[:, None, None]
        own_size = (2.0 * armature + f * np.maximum(np.abs(borne.most), borne.least))[:, None]
        if kind == "level":
            s = float(np.sqrt((1.0 - gamma) * (1.0 + gamma)))
            mixing = np.concatenate((mixing, mixing * np.array([[0.0], [s]])), axis=2)
            own = np.zeros((n, 2, 2))
            # Over the armature's range the 2 × 2 part loses no more than this much along its negative direction.
            least, direction = (part[..., 0] for part in np.linalg.eigh(np.array([[2.0, s], [s, 0.0]])))
            own[:, 0, 0], own[:, 1, 1] = 2.0 * armature - f * borne.most, f * borne.least
            own[:, 0, 1] = own[:, 1, 0] = s * armature
            own -= (slack * abs(float(least)))[:, None, None] * np.outer(direction, direction)
            own_size = np.repeat(own_size, 2, axis=1) + (s * armature + 2.0 * slack)[:, None]
    exact, range_1 = _followed(chain, lower, upper)
    return Form(chain, pairing, mixing, own, own_size, exact, range_1, lower, upper)


def _followed(chain: Chain, lower: Array, upper: Array) -> tuple[bool, tuple[float, float]]:
    """Whether joint 1 is followed exactly, and over which range."""
    if not (chain.parent.size > 1 and chain.parent[1] == 0 and not chain.slides[1]):
        return False, (0.0, 0.0)
    # One turn of it is all there is.
    return True, (float(lower[1]), min(float(upper[1]), float(lower[1]) + _TURN))


def joint_space(form: Form, q: Array) -> Array:
    """The form's matrix in joint velocities at configurations q (..., n), result (..., n e, n e)."""
    n, e = form.chain.parent.size, form.mixing.shape[2]
    weights = np.einsum("ipk,pr,jrl->ijkl", form.mixing, form.pairing, form.mixing)
    M = form.chain.mass_matrix(q, np.zeros(n))
    P = np.einsum("...ij,ijkl->...ikjl", M, weights)
    k = np.arange(n)
    P[..., k, :, k, :] += form.own.reshape(n, *(1,) * (P.ndim - 4), e, e)
    return np.asarray(P.reshape(*P.shape[:-4], n * e, n * e))


def least_eigenvalues(form: Form, q: Array) -> Array:
    """The least eigenvalue of that matrix over the largest, of the arm at coordinates q (..., nv), result (...)."""
    P = joint_space(form, form.chain.joints(q))
    if form.chain.follows:
        S = np.kron(form.chain.spread, np.eye(form.mixing.shape[2]))
        P = S.T @ P @ S
    values = np.linalg.eigvalsh(P)
    return np.asarray(values[..., 0] / np.abs(values[..., -1]))


def metrics(form: Form, c: Array) -> tuple[list[Array], list[Array], list[Array], Array]:
    """For each joint: a square root of the metric of its losses, its inverse, and the weakest motion's twist before it.

    All three only guide; none is relied upon. Shapes (B, 6p, 6p) twice and (B, 6p). And the form's least eigenvalue at
    the centre over its largest, shape (B,).
    """
    chain = form.chain
    n, p, e = chain.parent.size, form.pairing.shape[0], form.mixing.shape[2]
    q = c.copy()
    if form.exact:
        trial = np.linspace(*form.range_1, 25)
        many = np.repeat(q[:, None], trial.size, axis=1)
        many[:, :, 1] = trial
        tried = np.stack([np.linalg.eigvalsh(joint_space(form, many[:, k]))[:, 0] for k in range(trial.size)], axis=1)
        q[:, 1] = trial[np.argmin(tried, axis=1)]
    values, vectors = np.linalg.eigh(joint_space(form, q))
    least = values[:, 0] / np.abs(values[:, -1])
    values = np.maximum(values, 1e-9 * np.abs(values[:, -1:]))
    compliance = (vectors / values[:, None, :]) @ transposed(vectors)
    weakest = vectors[:, :, 0]
    J = chain.jacobians(q)
    # Twists of every body by all velocities: (B, n, 6p, n e).
    lifted = np.einsum("bkaj,jpe->bkpaje", J, form.mixing).reshape(len(c), n, 6 * p, n * e)
    rigid = [np.broadcast_to(chain.inertia[i], (len(c), 6, 6)).copy() for i in range(n)]
    roots: list[Array] = [np.empty(0)] * n
    inverses: list[Array] = [np.empty(0)] * n
    weak: list[Array] = [np.empty(0)] * n
    for i in range(n - 1, 0, -1):
        parent = chain.parent[i]
        if parent < 0:
            continue
        X = chain.transform(i, q[:, i])
        carried = transposed(X) @ rigid[i] @ X
        rigid[parent] += carried
        k = np.arange(6)
        # A point mass resists no turning about itself, yet a turn of the joint takes it elsewhere.
        carried[:, k, k] += _LIFT * carried[:, k, k] + 1e-9 * np.trace(carried, axis1=1, axis2=2)[:, None] + 1e-12
        before = lifted[:, parent]
        weak[i] = np.einsum("baj,bj->ba", before, weakest)
        free = before @ compliance @ transposed(before)
        L = np.linalg.cholesky(carried)
        L = np.broadcast_to(L[:, None], (len(c), p, 6, 6))
        own = np.stack([free[:, 6 * a : 6 * a + 6, 6 * a : 6 * a + 6] for a in range(p)], axis=1)
        scale = np.sqrt(np.trace(transposed(L) @ own @ L, axis1=-2, axis2=-1).clip(1e-300))
        # Each twist weighed by how freely the joints before this one move it.
        weight = np.sqrt(scale[:, ::-1] / scale)
        big = np.zeros((len(c), 6 * p, 6 * p))
        for a in range(p):
            block = slice(6 * a, 6 * a + 6)
            big[:, block, block] = L[:, a] * weight[:, a, None, None]
        Γ = transposed(big) @ free @ big
        Γ /= np.trace(Γ, axis1=1, axis2=2).clip(1e-300)[:, None, None]
        k = np.arange(6 * p)
        Γ[:, k, k] += _SHARE
        U = np.linalg.cholesky(Γ)
        roots[i] = big @ transposed(np.linalg.inv(U))
        inverses[i] = transposed(U) @ np.linalg.inv(big)
    return roots, inverses, weak, least


def transposed(A: Array) -> Array:
    """The last two axes exchanged."""
    return np.swapaxes(A, -1, -2)
