"""The arm as compiled code sees it: inertia matrix and the gradient of xᵀ M(q) y, without allocation.

Everything is written in the base frame, where composite inertias add up and moving joint k shifts all that lies beyond
it as one rigid body: that makes ∂(xᵀ M y)/∂q_k one pass over the tree (see `bilinear_gradient`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numba
import numpy as np

from asmc_pin._typing import Array, BoolArray, IntArray

if TYPE_CHECKING:
    from asmc_pin.arms import Arm


class Chain(NamedTuple):
    """The arm's tree in the form that compiled code takes; fields as in `asmc_pin.arms.Tree`."""

    parent: IntArray
    rotation: Array
    translation: Array
    axis: Array
    prismatic: BoolArray
    mass: Array
    com: Array
    inertia: Array


def chain_of(arm: Arm) -> Chain:
    """The compiled form of an arm, without its armature, which the kernels take separately."""
    return Chain(*(np.ascontiguousarray(getattr(arm.tree, name)) for name in Chain._fields))


@numba.njit(cache=True, nogil=True, error_model="numpy")
def place(chain: Chain, q: Array, turn: Array, origin: Array, subspace: Array) -> None:
    """World rotation and origin of every joint frame, and the joint's motion subspace (angular, linear) at the base."""
    local = np.empty((3, 3))
    for i in range(q.shape[0]):
        x, y, z = chain.axis[i, 0], chain.axis[i, 1], chain.axis[i, 2]
        if chain.prismatic[i]:
            s, c = 0.0, 1.0
        else:
            s, c = np.sin(q[i]), np.cos(q[i])
        k = 1.0 - c
        local[0, 0], local[0, 1], local[0, 2] = c + x * x * k, x * y * k - z * s, x * z * k + y * s
        local[1, 0], local[1, 1], local[1, 2] = x * y * k + z * s, c + y * y * k, y * z * k - x * s
        local[2, 0], local[2, 1], local[2, 2] = x * z * k - y * s, y * z * k + x * s, c + z * z * k
        p = chain.parent[i]
        placed = chain.rotation[i]
        offset = chain.translation[i]
        for a in range(3):
            if p < 0:
                r0, r1, r2 = placed[a, 0], placed[a, 1], placed[a, 2]
                origin[i, a] = offset[a]
            else:
                t0, t1, t2 = turn[p, a, 0], turn[p, a, 1], turn[p, a, 2]
                r0 = t0 * placed[0, 0] + t1 * placed[1, 0] + t2 * placed[2, 0]
                r1 = t0 * placed[0, 1] + t1 * placed[1, 1] + t2 * placed[2, 1]
                r2 = t0 * placed[0, 2] + t1 * placed[1, 2] + t2 * placed[2, 2]
                origin[i, a] = origin[p, a] + t0 * offset[0] + t1 * offset[1] + t2 * offset[2]
            for b in range(3):
                turn[i, a, b] = r0 * local[0, b] + r1 * local[1, b] + r2 * local[2, b]
            subspace[i, a] = r0 * x + r1 * y + r2 * z
        if chain.prismatic[i]:
            for a in range(3):
                origin[i, a] += subspace[i, a] * q[i]
                subspace[i, 3 + a] = subspace[i, a]
                subspace[i, a] = 0.0
        else:
            subspace[i, 3] = origin[i, 1] * subspace[i, 2] - origin[i, 2] * subspace[i, 1]
            subspace[i, 4] = origin[i, 2] * subspace[i, 0] - origin[i, 0] * subspace[i, 2]
            subspace[i, 5] = origin[i, 0] * subspace[i, 1] - origin[i, 1] * subspace[i, 0]


@numba.njit(cache=True, nogil=True, error_model="numpy")
def composite(chain: Chain, turn: Array, origin: Array, body: Array, rotated: Array) -> None:
    """Mass, first moment and inertia about the base origin (xx, xy, yy, xz, yz, zz) of each joint's whole subtree."""
    n = turn.shape[0]
    for i in range(n):
        m = chain.mass[i]
        cx, cy, cz = origin[i, 0], origin[i, 1], origin[i, 2]
        for b in range(3):
            cx += turn[i, 0, b] * chain.com[i, b]
            cy += turn[i, 1, b] * chain.com[i, b]
            cz += turn[i, 2, b] * chain.com[i, b]
        for a in range(3):
            for b in range(3):
                rotated[a, b] = (
                    turn[i, a, 0] * chain.inertia[i, 0, b]
                    + turn[i, a, 1] * chain.inertia[i, 1, b]
                    + turn[i, a, 2] * chain.inertia[i, 2, b]
                )
        body[i, 0], body[i, 1], body[i, 2], body[i, 3] = m, m * cx, m * cy, m * cz
        slot = 4
        for a in range(3):
            for b in range(a + 1):
                body[i, slot] = (
                    rotated[a, 0] * turn[i, b, 0] + rotated[a, 1] * turn[i, b, 1] + rotated[a, 2] * turn[i, b, 2]
                )
                slot += 1
        body[i, 4] += m * (cy * cy + cz * cz)
        body[i, 5] -= m * cx * cy
        body[i, 6] += m * (cx * cx + cz * cz)
        body[i, 7] -= m * cx * cz
        body[i, 8] -= m * cy * cz
        body[i, 9] += m * (cx * cx + cy * cy)


@numba.njit(cache=True, nogil=True, error_model="numpy")
def _apply(inertia: Array, v: Array, out: Array) -> None:
    """Spatial momentum about the base origin of a body that moves with the spatial velocity v = (angular, linear)."""
    m, hx, hy, hz = inertia[0], inertia[1], inertia[2], inertia[3]
    out[0] = inertia[4] * v[0] + inertia[5] * v[1] + inertia[7] * v[2] + hy * v[5] - hz * v[4]
    out[1] = inertia[5] * v[0] + inertia[6] * v[1] + inertia[8] * v[2] + hz * v[3] - hx * v[5]
    out[2] = inertia[7] * v[0] + inertia[8] * v[1] + inertia[9] * v[2] + hx * v[4] - hy * v[3]
    out[3] = m * v[3] - (hy * v[2] - hz * v[1])
    out[4] = m * v[4] - (hz * v[0] - hx * v[2])
    out[5] = m * v[5] - (hx * v[1] - hy * v[0])


@numba.njit(cache=True, nogil=True, error_model="numpy")
def fill_mass(chain: Chain, armature: Array, subspace: Array, body: Array, force: Array, mass: Array) -> None:
    """Composite rigid body algorithm; `body` turns from single links into subtrees."""
    n = subspace.shape[0]
    mass[:, :] = 0.0
    for i in range(n - 1, -1, -1):
        p = chain.parent[i]
        if p >= 0:
            for k in range(10):
                body[p, k] += body[i, k]
        _apply(body[i], subspace[i], force)
        j = i
        while j >= 0:
            total = 0.0
            for k in range(6):
                total += subspace[j, k] * force[k]
            mass[i, j] = total
            mass[j, i] = total
            j = chain.parent[j]
        mass[i, i] += armature[i]


@numba.njit(cache=True, nogil=True, error_model="numpy")
def bilinear_gradient(
    chain: Chain, subspace: Array, body: Array, x: Array, y: Array, velocity: Array, momentum: Array, out: Array
) -> None:
    """∂(xᵀ M(q) y)/∂q_k for every k, by two velocity passes and two momentum passes; `body` holds subtrees.

    xᵀMy = Σ_j Vx_jᵀ I_j Vy_j. Moving joint k turns all bodies beyond it rigidly, which is the same as turning the
    velocity that enters them by the opposite motion: −S_k × V_k. So the derivative is
    −(S_k × Vx_k)·Py_k − (S_k × Vy_k)·Px_k, with P_k the momentum of the subtree.
    """
    n = subspace.shape[0]
    for side in range(2):
        rate = x if side == 0 else y
        for i in range(n):
            p = chain.parent[i]
            for k in range(6):
                velocity[side, i, k] = subspace[i, k] * rate[i] + (velocity[side, p, k] if p >= 0 else 0.0)
        # The subtree's momentum: its own composite moving with V_i, and what each later joint adds to its own subtree.
        for i in range(n - 1, -1, -1):
            for k in range(6):
                momentum[side, i, k] = 0.0
        moved = np.empty(6)
        added = np.empty(6)
        for i in range(n):
            for k in range(6):
                moved[k] = subspace[i, k] * rate[i]
            _apply(body[i], moved, added)
            j = chain.parent[i]
            while j >= 0:
                for k in range(6):
                    momentum[side, j, k] += added[k]
                j = chain.parent[j]
            _apply(body[i], velocity[side, i], added)
            for k in range(6):
                momentum[side, i, k] += added[k]
    for i in range(n):
        w0, w1, w2, u0, u1, u2 = subspace[i]
        total = 0.0
        for side in range(2):
            v = velocity[side, i]
            p = momentum[1 - side, i]
            total -= (w1 * v[2] - w2 * v[1]) * p[0]
            total -= (w2 * v[0] - w0 * v[2]) * p[1]
            total -= (w0 * v[1] - w1 * v[0]) * p[2]
            total -= (w1 * v[5] - w2 * v[4] + u1 * v[2] - u2 * v[1]) * p[3]
            total -= (w2 * v[3] - w0 * v[5] + u2 * v[0] - u0 * v[2]) * p[4]
            total -= (w0 * v[4] - w1 * v[3] + u0 * v[1] - u1 * v[0]) * p[5]
        out[i] = total
