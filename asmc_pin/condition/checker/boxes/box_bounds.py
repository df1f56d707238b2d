"""A second proof that a quadratic form is positive over boxes of joint cells, many boxes at a time.

The theorem is that of docs/certificate.md; nothing else is shared with the prover. Trigonometric parts come from five
samples per joint and a discrete Fourier transform, not from the form's entries; positivity from eigenvalues, not from a
Cholesky; metrics from explicit Jacobians; the arm from `links`.

Arrays begin with the box and the corner, (B, V, …).
"""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.condition.checker.boxes.quadratic_form import Form, metrics, transposed

WIDE = 1.4
"""Half width, rad, above which a turning joint is bounded by its mean over a turn."""

_TOLERANCE = 1e-12
"""Taken off for rounding, relative to the magnitudes that took part: some hundred times what they lose."""

_SLACK = 1e-9
_GRID = 64


def _lowered(A: Array, size: Array) -> Array:
    """A − tolerance · diag(size): below whatever the rounded A stands for, if size are its magnitudes' row sums."""
    out = 0.5 * (A + transposed(A))
    k = np.arange(A.shape[-1])
    out[..., k, k] -= _TOLERANCE * size
    return out


def _surely(A: Array, size: Array) -> BoolArray:
    """Whether A is positive definite, by its eigenvalues after scaling to a unit diagonal."""
    S = _lowered(A, size)
    diagonal = np.diagonal(S, axis1=-2, axis2=-1)
    good = np.asarray(np.all(diagonal > 0.0, axis=-1))
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    least = np.linalg.eigvalsh(S * scale[..., :, None] * scale[..., None, :])[..., 0]
    return good & (least > _TOLERANCE)


def _eliminated(A: Array, columns: Array, own: Array, own_size: Array) -> tuple[Array, BoolArray]:
    """The minimum over x of [twist + columns x]ᵀ A [twist + columns x] + xᵀ own x, from below; and where it exists."""
    bordered = np.concatenate((np.eye(A.shape[-1]), columns), axis=1)
    B = bordered.T @ A @ bordered
    m = A.shape[-1]
    B[..., m:, m:] += own
    size = (np.abs(bordered).T @ np.abs(A) @ np.abs(bordered)).sum(axis=-1)
    size[..., m:] += own_size
    good = np.ones(A.shape[:-2], dtype=np.bool_)
    B = _lowered(B, size)
    for k in range(B.shape[-1] - 1, m - 1, -1):
        pivot = B[..., k, k]
        good &= pivot > 1e-9 * size[..., k]
        pivot = np.where(good, pivot, 1.0)
        row = B[..., k, :k]
        B = B[..., :k, :k] - row[..., :, None] * row[..., None, :] / pivot[..., None, None]
        size = size[..., :k] + np.abs(row) * np.abs(row).sum(axis=-1, keepdims=True) / pivot[..., None]
        B = _lowered(B, size)
    return B, good


def _harmonics(form: Form, i: int, c: Array, F: Array) -> tuple[Array, Array]:
    """Coefficients of G(c + δ) = X(c+δ)ᵀ F X(c+δ) for 1, cos δ, sin δ, cos 2δ, sin 2δ (or 1, δ, δ² of a slide).

    Args:
        form: The statement.
        i: The joint.
        c: Centres, shape (B,).
        F: Shape (B, V, m, m).

    Returns:
        Coefficients, shape (5 or 3, B, V, m, m), and the magnitudes' row sums, shape (B, V, m).
    """
    slides = bool(form.chain.slides[i])
    at = np.array([-1.0, 0.0, 1.0]) if slides else 2.0 * np.pi * np.arange(5) / 5.0
    X = form.lift(form.chain.transform(i, c[None, :] + at[:, None]))[:, :, None]
    G = transposed(X) @ F[None] @ X
    size = (np.abs(transposed(X)) @ np.abs(F)[None] @ np.abs(X)).sum(axis=-1).max(axis=0)
    # An angle is rounded at its own size, and a form turns by as much as that.
    size = size * (4.0 if slides else 2.0 + np.abs(c)[:, None, None])
    if slides:
        return np.stack((G[1], 0.5 * (G[2] - G[0]), 0.5 * (G[2] + G[0]) - G[1])), size
    basis = np.stack((np.full(5, 0.5), np.cos(at), np.sin(at), np.cos(2 * at), np.sin(2 * at))) * 0.4
    return np.tensordot(basis, G, axes=1), size


def _covering(H: Array, both: bool, root: Array, inverse: Array, size: Array) -> tuple[Array, BoolArray]:
    """A small P ⪰ 0 with P + H ⪰ 0 (P ± H ⪰ 0 if both), in the metric root rootᵀ; and whether it passed the test."""
    W = inverse @ H @ transposed(inverse)
    values, vectors = np.linalg.eigh(W)
    part = np.abs(values) if both else np.maximum(-values, 0.0)
    part = part + _SLACK * np.abs(values).max(axis=-1, keepdims=True)
    Z = root @ vectors
    P = (Z * part[..., None, :]) @ transposed(Z)
    k = np.arange(H.shape[-1])
    P[..., k, k] += 8.0 * _TOLERANCE * size
    total = size + np.abs(P).sum(axis=-1)
    good = _surely(P + H, total)
    good &= _surely(P - H, total) if both else _surely(P, total)
    return P, good


def _ends(
    form: Form, i: int, c: Array, r: Array, F: Array, root: Array, inverse: Array
) -> tuple[Array, Array, BoolArray]:
    """Forms at the ends of joint i's cell with the loss taken off, in the parent's frame.

    Returns:
        (B, V, ends, m, m), the loss (B, V, m, m), and whether it is sure, (B, V).
    """
    root, inverse = root[:, None], inverse[:, None]
    C, size = _harmonics(form, i, c, F)
    wide = r[:, None, None, None]
    if form.chain.slides[i]:
        P, good = _covering(-C[2], False, root, inverse, size)
        K = wide * wide * P
        ends = [C[0] + s * wide * C[1] + wide * wide * C[2] - K for s in (-1.0, 1.0)]
    elif r[0] > WIDE:
        K, good = np.zeros_like(F), np.ones(F.shape[:2], dtype=np.bool_)
        for k in range(1, 5):
            P, passed = _covering(C[k], True, root, inverse, size)
            K, good = K + P, good & passed
        ends = [C[0] - K]
    else:
        cosine, sine = np.cos(wide), np.sin(wide)
        kappa = 2.0 * np.sin(0.5 * wide) ** 2
        # The largest (cos δ − cos r) |sin δ|, by y = 1 − cos δ, which keeps its digits in narrow cells.
        y = 2.0 * kappa / (3.0 + kappa + np.sqrt((3.0 + kappa) ** 2 - 8.0 * kappa))
        third = (kappa - y) * np.sqrt(y * (2.0 - y))
        first, good = _covering(C[1] + (2.0 + 2.0 * cosine) * C[3], False, root, inverse, size)
        second, sure = _covering(C[4], True, root, inverse, size)
        curved, also = _covering(-C[3], False, root, inverse, size)
        good &= sure & also
        K = (kappa * first + 2.0 * third * second + 0.5 * kappa**2 * curved) * (1.0 + _SLACK)
        even = C[0] + cosine * C[1] + (2.0 * cosine**2 - 1.0) * C[3] - K
        odd = sine * C[2] + 2.0 * sine * cosine * C[4]
        ends = [even - odd, even + odd]
    size = size[:, :, None] * (2.0 + wide * wide) + np.abs(K).sum(axis=-1)[:, :, None]
    return _lowered(np.stack(ends, axis=2), size), K, good


def holds(form: Form, c: Array, r: Array) -> tuple[BoolArray, Array, Array]:
    """Whether the form is positive over each box of cells; all boxes have the same joints wide.

    Args:
        form: The statement.
        c: Centres, shape (B, n).
        r: Half widths, shape (B, n).

    Returns:
        Proven, shape (B,); for each joint what its cell costs in the weakest motion at the centre, shape (B, n); the
        form's least eigenvalue at the centre over its largest, shape (B,).
    """
    chain = form.chain
    n, B = chain.parent.size, len(c)
    roots, inverses, weak, least = metrics(form, c)
    m = 6 * form.pairing.shape[0]
    forms = [np.broadcast_to(form.body(i), (B, 1, m, m)).copy() for i in range(n)]
    good = np.ones((B, 1), dtype=np.bool_)
    cost = np.zeros((B, n))
    for i in range(n - 1, -1, -1):
        F, fine = _eliminated(forms[i], form.columns(i), form.own[i], form.own_size[i])
        good = good & fine
        parent = chain.parent[i]
        if parent < 0:
            continue
        if i == 1 and form.exact:
            good = good & _follow(form, forms[0], F)
            break
        ends, K, sure = _ends(form, i, c[:, i], r[:, i], F, roots[i], inverses[i])
        cost[:, i] = np.einsum("ba,bvac,bc->bv", weak[i], K, weak[i]).max(axis=1)
        good = good & sure
        # Every corner so far goes on with every end of this joint.
        count = ends.shape[2]
        forms = [np.repeat(A, count, axis=1) for A in forms]
        good = np.repeat(good, count, axis=1)
        A = forms[parent] + ends.reshape(B, -1, m, m)
        size = np.abs(forms[parent]).sum(axis=-1) + np.abs(ends).reshape(B, -1, m, m).sum(axis=-1)
        forms[parent] = _lowered(A, size)
    return np.asarray(good.all(axis=1)), cost, least


def _follow(form: Form, A: Array, F: Array) -> BoolArray:
    """Whether the base joint's own form is positive for every angle of joint 1."""
    lower, upper = form.range_1
    C, size = _harmonics(form, 1, np.zeros(len(A)), F)
    s = form.columns(0)
    C = s.T @ C @ s
    C[0] += s.T @ A @ s + form.own[0]
    taken = size + np.abs(A).sum(axis=-1)
    error = (np.abs(s).T ** 2 @ taken[..., None]).sum(axis=(-1, -2)) + form.own_size[0].sum()
    norm = np.linalg.norm(C, axis=(-1, -2))
    curvature = norm[1] + norm[2] + 4.0 * (norm[3] + norm[4])
    margin = 8.0 * _TOLERANCE * (error + norm.sum(axis=0))
    done, failed = np.zeros(A.shape[:2], dtype=np.bool_), np.zeros(A.shape[:2], dtype=np.bool_)
    count = _GRID
    while count <= _GRID * 4096 and not np.all(done | failed):
        todo = ~(done | failed)
        q = np.linspace(lower, upper, count + 1)
        basis = np.stack((np.ones_like(q), np.cos(q), np.sin(q), np.cos(2 * q), np.sin(2 * q)))
        step = float(np.diff(q).max(initial=0.0)) * (1.0 + _SLACK) + 4.0 * np.finfo(np.float64).eps * abs(q).max()
        least = np.full(int(todo.sum()), np.inf)
        chosen = np.ascontiguousarray(C[:, todo])
        for start in range(0, count + 1, 256):
            values = np.tensordot(basis[:, start : start + 256], chosen, axes=(0, 0))
            least = np.minimum(least, np.linalg.eigvalsh(values)[..., 0].min(axis=0))
        # Between two points of the grid a form is at least their mix less this.
        done[todo] = least - 0.125 * step**2 * curvature[todo] > margin[todo]
        failed[todo] = least <= margin[todo]
        count *= 8
    return done
