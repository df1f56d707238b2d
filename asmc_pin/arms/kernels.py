"""The mass matrix, compiled: a composite rigid body algorithm over `Tree` for many configurations at once.

Pinocchio has no batched crba in Python. Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 6, in joint
frames; composite bodies are kept as mass, centre and inertia about the centre, which loses no digits for a light hand
at the end of a long arm.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.arms.batch import joint_rows
from asmc_pin.arms.tree import Tree


@njit(cache=True, nogil=True, inline="always")
def _place(rotation: Array, translation: Array, axis: Array, prismatic: bool, q: float, R: Array, p: Array) -> None:
    """Write the pose of a joint's frame in its parent's, at joint value q, into R (3, 3) and p (3,)."""
    if prismatic:
        for r in range(3):
            p[r] = translation[r]
            for c in range(3):
                R[r, c] = rotation[r, c]
                p[r] += rotation[r, c] * axis[c] * q
        return
    x, y, z = axis[0], axis[1], axis[2]
    s, c = np.sin(q), np.cos(q)
    t = 1.0 - c
    # Rodrigues' formula, column by column of rotation @ exp(q axis×).
    for r in range(3):
        a, b, d = rotation[r, 0], rotation[r, 1], rotation[r, 2]
        R[r, 0] = a * (c + t * x * x) + b * (t * x * y + s * z) + d * (t * x * z - s * y)
        R[r, 1] = a * (t * x * y - s * z) + b * (c + t * y * y) + d * (t * y * z + s * x)
        R[r, 2] = a * (t * x * z + s * y) + b * (t * y * z - s * x) + d * (c + t * z * z)
        p[r] = translation[r]


@njit(cache=True, nogil=True)
def crba(
    parent: IntArray,
    rotation: Array,
    translation: Array,
    axis: Array,
    prismatic: BoolArray,
    mass: Array,
    com: Array,
    inertia: Array,
    armature: Array,
    q: Array,
) -> Array:
    """Joint-space inertia M(q), armature on its diagonal included.

    Args:
        parent: `Tree.parent`; the following are the tree's fields of the same names.
        rotation: (nv, 3, 3).
        translation: (nv, 3).
        axis: (nv, 3).
        prismatic: (nv,).
        mass: (nv,).
        com: (nv, 3).
        inertia: (nv, 3, 3).
        armature: (nv,).
        q: Joint values, shape (batch, nv), rad (m where prismatic).

    Returns:
        Shape (batch, nv, nv), kg·m², exactly symmetric.
    """
    batch, nv = q.shape
    out = np.zeros((batch, nv, nv))
    R = np.empty((nv, 3, 3))
    p = np.empty((nv, 3))
    m = np.empty(nv)
    h = np.empty((nv, 3))
    I = np.empty((nv, 3, 3))  # noqa: E741 - the letter of every textbook
    c = np.empty(3)
    d = np.empty(3)
    lin = np.empty(3)
    ang = np.empty(3)
    new_lin = np.empty(3)
    new_ang = np.empty(3)
    T = np.empty((3, 3))
    for b in range(batch):
        for i in range(nv):
            _place(rotation[i], translation[i], axis[i], prismatic[i], q[b, i], R[i], p[i])
            m[i] = mass[i]
            h[i] = com[i]
            I[i] = inertia[i]
        for i in range(nv - 1, -1, -1):
            j = parent[i]
            if j >= 0 and m[i] > 0.0:
                # Composite of i, seen from its parent: rotate, move, then merge about the common centre.
                for r in range(3):
                    c[r] = p[i, r] + R[i, r, 0] * h[i, 0] + R[i, r, 1] * h[i, 1] + R[i, r, 2] * h[i, 2]
                    for k in range(3):
                        T[r, k] = R[i, r, 0] * I[i, 0, k] + R[i, r, 1] * I[i, 1, k] + R[i, r, 2] * I[i, 2, k]
                total = m[i] + m[j]
                reduced = m[i] * m[j] / total
                for r in range(3):
                    d[r] = c[r] - h[j, r]
                square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
                for r in range(3):
                    for k in range(3):
                        I[j, r, k] += T[r, 0] * R[i, k, 0] + T[r, 1] * R[i, k, 1] + T[r, 2] * R[i, k, 2]
                        I[j, r, k] -= reduced * d[r] * d[k]
                    I[j, r, r] += reduced * square
                for r in range(3):
                    h[j, r] += (m[i] / total) * d[r]
                m[j] = total
        for i in range(nv):
            a = axis[i]
            # Momentum of the composite of i under unit velocity of joint i, about the joint's origin, in its frame.
            if prismatic[i]:
                for r in range(3):
                    lin[r] = m[i] * a[r]
                    ang[r] = 0.0
            else:
                lin[0] = m[i] * (a[1] * h[i, 2] - a[2] * h[i, 1])
                lin[1] = m[i] * (a[2] * h[i, 0] - a[0] * h[i, 2])
                lin[2] = m[i] * (a[0] * h[i, 1] - a[1] * h[i, 0])
                for r in range(3):
                    ang[r] = I[i, r, 0] * a[0] + I[i, r, 1] * a[1] + I[i, r, 2] * a[2]
            ang[0] += h[i, 1] * lin[2] - h[i, 2] * lin[1]
            ang[1] += h[i, 2] * lin[0] - h[i, 0] * lin[2]
            ang[2] += h[i, 0] * lin[1] - h[i, 1] * lin[0]
            k = i
            while True:
                f = lin if prismatic[k] else ang
                value = axis[k, 0] * f[0] + axis[k, 1] * f[1] + axis[k, 2] * f[2]
                out[b, i, k] = value
                out[b, k, i] = value
                if parent[k] < 0:
                    break
                for r in range(3):
                    new_lin[r] = R[k, r, 0] * lin[0] + R[k, r, 1] * lin[1] + R[k, r, 2] * lin[2]
                    new_ang[r] = R[k, r, 0] * ang[0] + R[k, r, 1] * ang[1] + R[k, r, 2] * ang[2]
                ang[0] = new_ang[0] + p[k, 1] * new_lin[2] - p[k, 2] * new_lin[1]
                ang[1] = new_ang[1] + p[k, 2] * new_lin[0] - p[k, 0] * new_lin[2]
                ang[2] = new_ang[2] + p[k, 0] * new_lin[1] - p[k, 1] * new_lin[0]
                lin[:] = new_lin
                k = parent[k]
            out[b, i, i] += armature[i]
    return out


def mass_matrices(tree: Tree, q: Array) -> Array:
    """M(q) by the compiled kernel; equals Pinocchio's crba plus armature to rounding.

    Args:
        tree: The arm's tree, `Arm.tree`.
        q: Joint values, shape (..., nv), rad (m where prismatic).

    Returns:
        Shape (..., nv, nv), kg·m².

    Raises:
        ParameterError: The last axis of q is not nv long.
    """
    lead, (rows,) = joint_rows([f"joint {k}" for k in range(tree.nv)], {"q": q})
    mass: Array = crba(
        tree.parent,
        tree.rotation,
        tree.translation,
        tree.axis,
        tree.prismatic,
        tree.mass,
        tree.com,
        tree.inertia,
        tree.armature,
        np.ascontiguousarray(rows),
    )
    return mass.reshape(*lead, tree.nv, tree.nv)
