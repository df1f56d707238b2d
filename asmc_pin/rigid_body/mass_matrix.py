"""The mass matrix, compiled: a composite rigid body algorithm over `Tree` for many configurations at once.

Pinocchio has no batched crba in Python. Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 6. Every vector
has the base's axes but starts at a joint's own origin, and composite bodies are kept as mass, centre and inertia about
the centre: nothing is turned on the way to the base, and a light hand at the end of a long arm loses no digits.

Small matrices are tuples, row by row, which stay in registers; the same with little arrays takes five times as long.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.rigid_body.leading_axes import joint_rows
from asmc_pin.rigid_body.tree import Tree

Vector = tuple[float, float, float]
Matrix = tuple[float, float, float, float, float, float, float, float, float]
Symmetric = tuple[float, float, float, float, float, float]  # xx, xy, xz, yy, yz, zz

_compiled = njit(cache=True, nogil=True, error_model="numpy")


@_compiled
def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@_compiled
def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@_compiled
def _add(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@_compiled
def _turn(R: Matrix, x: Vector) -> Vector:
    return (
        R[0] * x[0] + R[1] * x[1] + R[2] * x[2],
        R[3] * x[0] + R[4] * x[1] + R[5] * x[2],
        R[6] * x[0] + R[7] * x[1] + R[8] * x[2],
    )


@_compiled
def _product(A: Matrix, B: Matrix) -> Matrix:
    x, y, z = _turn(A, (B[0], B[3], B[6])), _turn(A, (B[1], B[4], B[7])), _turn(A, (B[2], B[5], B[8]))
    return x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]


@_compiled
def _about(axis: Vector, angle: float) -> Matrix:
    """Rodrigues' formula."""
    x, y, z = axis
    s, c = np.sin(angle), np.cos(angle)
    t = 1.0 - c
    return (
        c + t * x * x,
        t * x * y - s * z,
        t * x * z + s * y,
        t * x * y + s * z,
        c + t * y * y,
        t * y * z - s * x,
        t * x * z - s * y,
        t * y * z + s * x,
        c + t * z * z,
    )


@_compiled
def _turned(R: Matrix, body: Symmetric) -> Symmetric:
    """R I Rᵀ."""
    xx, xy, xz, yy, yz, zz = body
    T = _product(R, (xx, xy, xz, xy, yy, yz, xz, yz, zz))
    row0, row1, row2 = (R[0], R[1], R[2]), (R[3], R[4], R[5]), (R[6], R[7], R[8])
    x, y, z = (T[0], T[1], T[2]), (T[3], T[4], T[5]), (T[6], T[7], T[8])
    return _dot(x, row0), _dot(x, row1), _dot(x, row2), _dot(y, row1), _dot(y, row2), _dot(z, row2)


@_compiled
def _applied(body: Symmetric, x: Vector) -> Vector:
    """I x."""
    return _turn((body[0], body[1], body[2], body[1], body[3], body[4], body[2], body[4], body[5]), x)


@_compiled
def _lay_out(
    i: int,
    j: int,
    rotation: Array,
    translation: Array,
    axis: Array,
    prismatic: BoolArray,
    com: Array,
    inertia: Array,
    q: float,
    R: Array,
    d: Array,
    a: Array,
    c: Array,
    B: Array,
) -> None:
    """Write joint i, whose parent is j, into the tables of `crba`."""
    P = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    if j >= 0:
        P = (R[j, 0], R[j, 1], R[j, 2], R[j, 3], R[j, 4], R[j, 5], R[j, 6], R[j, 7], R[j, 8])
    A = rotation
    turn = _product(
        P, (A[i, 0, 0], A[i, 0, 1], A[i, 0, 2], A[i, 1, 0], A[i, 1, 1], A[i, 1, 2], A[i, 2, 0], A[i, 2, 1], A[i, 2, 2])
    )
    own = (axis[i, 0], axis[i, 1], axis[i, 2])
    s = _turn(turn, own)
    step = _turn(P, (translation[i, 0], translation[i, 1], translation[i, 2]))
    if prismatic[i]:
        step = _add(step, (q * s[0], q * s[1], q * s[2]))
    else:
        turn = _product(turn, _about(own, q))
    R[i, 0], R[i, 1], R[i, 2], R[i, 3], R[i, 4], R[i, 5], R[i, 6], R[i, 7], R[i, 8] = turn
    d[i, 0], d[i, 1], d[i, 2] = step
    a[i, 0], a[i, 1], a[i, 2] = s
    c[i, 0], c[i, 1], c[i, 2] = _turn(turn, (com[i, 0], com[i, 1], com[i, 2]))
    I = inertia  # noqa: E741 - the letter of every textbook
    body = _turned(turn, (I[i, 0, 0], I[i, 0, 1], I[i, 0, 2], I[i, 1, 1], I[i, 1, 2], I[i, 2, 2]))
    B[i, 0], B[i, 1], B[i, 2], B[i, 3], B[i, 4], B[i, 5] = body


@_compiled
def _merge(i: int, j: int, d: Array, m: Array, c: Array, B: Array) -> None:
    """Add all that joint i moves to what its parent j moves."""
    share = m[i] / (m[i] + m[j])
    w = share * m[j]
    x = d[i, 0] + c[i, 0] - c[j, 0]
    y = d[i, 1] + c[i, 1] - c[j, 1]
    z = d[i, 2] + c[i, 2] - c[j, 2]
    m[j] += m[i]
    c[j, 0] += share * x
    c[j, 1] += share * y
    c[j, 2] += share * z
    B[j, 0] += B[i, 0] + w * (y * y + z * z)
    B[j, 1] += B[i, 1] - w * x * y
    B[j, 2] += B[i, 2] - w * x * z
    B[j, 3] += B[i, 3] + w * (x * x + z * z)
    B[j, 4] += B[i, 4] - w * y * z
    B[j, 5] += B[i, 5] + w * (x * x + y * y)


@_compiled
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
        mass: (nv,), positive.
        com: (nv, 3).
        inertia: (nv, 3, 3).
        armature: (nv,).
        q: Joint values, shape (batch, nv), rad (m where prismatic).

    Returns:
        Shape (batch, nv, nv), kg·m², exactly symmetric.
    """
    batch, nv = q.shape
    out = np.zeros((batch, nv, nv))
    R = np.empty((nv, 9))  # orientation
    d = np.empty((nv, 3))  # from the parent joint's origin to this one's
    a = np.empty((nv, 3))  # axis
    m = np.empty(nv)  # mass, centre and inertia of all that the joint moves
    c = np.empty((nv, 3))
    B = np.empty((nv, 6))
    for b in range(batch):
        for i in range(nv):
            m[i] = mass[i]
            j = parent[i]
            _lay_out(i, j, rotation, translation, axis, prismatic, com, inertia, q[b, i], R, d, a, c, B)
        for i in range(nv - 1, -1, -1):
            if parent[i] >= 0:
                _merge(i, parent[i], d, m, c, B)
            # Momentum of all that joint i moves at unit velocity, and its moment about the joint's origin.
            s = (a[i, 0], a[i, 1], a[i, 2])
            centre = (c[i, 0], c[i, 1], c[i, 2])
            v = s if prismatic[i] else _cross(s, centre)
            momentum = (m[i] * v[0], m[i] * v[1], m[i] * v[2])
            moment = _cross(centre, momentum)
            if not prismatic[i]:
                moment = _add(moment, _applied((B[i, 0], B[i, 1], B[i, 2], B[i, 3], B[i, 4], B[i, 5]), s))
            k = i
            while k >= 0:
                out[b, i, k] = _dot((a[k, 0], a[k, 1], a[k, 2]), momentum if prismatic[k] else moment)
                out[b, k, i] = out[b, i, k]
                moment = _add(moment, _cross((d[k, 0], d[k, 1], d[k, 2]), momentum))
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
        np.array(rows, order="C"),  # a copy is always writable, so one compiled signature serves every caller
    )
    return mass.reshape(*lead, tree.nv, tree.nv)
