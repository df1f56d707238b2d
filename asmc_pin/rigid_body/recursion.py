"""The one compiled recursion over a tree of links: placed joints, composite bodies, the mass matrix.

Pinocchio has no batched crba in Python. Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 6. Every vector
has the base's axes but starts at a joint's own origin, and composite bodies are kept as mass, centre and inertia about
the centre: nothing is turned on the way to the base, and a light hand at the end of a long arm loses no digits.

Small matrices are tuples, row by row, which stay in registers; the same with little arrays takes five times as long.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.rigid_body.tree import Tree

Vector = tuple[float, float, float]
Matrix = tuple[float, float, float, float, float, float, float, float, float]
Symmetric = tuple[float, float, float, float, float, float]  # xx, xy, xz, yy, yz, zz

compiled = njit(cache=True, nogil=True, error_model="numpy")


@compiled
def cross(a: Vector, b: Vector) -> Vector:
    """A × b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled
def dot(a: Vector, b: Vector) -> float:
    """aᵀ b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def add(a: Vector, b: Vector) -> Vector:
    """A + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@compiled
def turn(R: Matrix, x: Vector) -> Vector:
    """R x."""
    return (
        R[0] * x[0] + R[1] * x[1] + R[2] * x[2],
        R[3] * x[0] + R[4] * x[1] + R[5] * x[2],
        R[6] * x[0] + R[7] * x[1] + R[8] * x[2],
    )


@compiled
def product(A: Matrix, B: Matrix) -> Matrix:
    """A B."""
    x, y, z = turn(A, (B[0], B[3], B[6])), turn(A, (B[1], B[4], B[7])), turn(A, (B[2], B[5], B[8]))
    return x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]


@compiled
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


@compiled
def turned(R: Matrix, body: Symmetric) -> Symmetric:
    """R I Rᵀ."""
    xx, xy, xz, yy, yz, zz = body
    T = product(R, (xx, xy, xz, xy, yy, yz, xz, yz, zz))
    row0, row1, row2 = (R[0], R[1], R[2]), (R[3], R[4], R[5]), (R[6], R[7], R[8])
    x, y, z = (T[0], T[1], T[2]), (T[3], T[4], T[5]), (T[6], T[7], T[8])
    return dot(x, row0), dot(x, row1), dot(x, row2), dot(y, row1), dot(y, row2), dot(z, row2)


@compiled
def applied(body: Symmetric, x: Vector) -> Vector:
    """I x."""
    return turn((body[0], body[1], body[2], body[1], body[3], body[4], body[2], body[4], body[5]), x)


class Links(NamedTuple):
    """A tree in the form that compiled code takes; fields as in `Tree` and `Coupling`, without armature and gravity."""

    parent: IntArray
    rotation: Array
    translation: Array
    axis: Array
    prismatic: BoolArray
    mass: Array
    com: Array
    inertia: Array
    coordinate: IntArray
    ratio: Array
    offset: Array


def links_of(tree: Tree) -> Links:
    """The compiled form of a tree: copies, because numba looks up a read-only array's type at every call, 1 µs each."""
    parts = {**vars(tree), **vars(tree.coupling)}
    return Links(*(np.array(parts[name], order="C") for name in Links._fields))


class Placed(NamedTuple):
    """Scratch for one configuration: the joints where they are, and what each of them moves.

    Attributes:
        R: Orientation of each joint's frame, row by row, shape (n, 9).
        d: From the parent joint's origin to this one's, shape (n, 3), m.
        a: Axis, shape (n, 3).
        m: Mass of all that the joint moves, shape (n,), kg.
        c: Its centre from the joint's origin, shape (n, 3), m.
        B: Its inertia about that centre, xx, xy, xz, yy, yz, zz, shape (n, 6), kg·m².
    """

    R: Array
    d: Array
    a: Array
    m: Array
    c: Array
    B: Array


@compiled
def scratch(n: int) -> Placed:
    """Room for one configuration of n joints, those that mimic others included."""
    return Placed(np.empty((n, 9)), np.empty((n, 3)), np.empty((n, 3)), np.empty(n), np.empty((n, 3)), np.empty((n, 6)))


@compiled
def _lay_out(links: Links, i: int, q: float, placed: Placed) -> None:
    """Place joint i and its own body; its parent is placed."""
    R, d, a, c, B = placed.R, placed.d, placed.a, placed.c, placed.B
    j = links.parent[i]
    P = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    if j >= 0:
        P = (R[j, 0], R[j, 1], R[j, 2], R[j, 3], R[j, 4], R[j, 5], R[j, 6], R[j, 7], R[j, 8])
    A, axis, translation, com = links.rotation, links.axis, links.translation, links.com
    R_i = product(
        P, (A[i, 0, 0], A[i, 0, 1], A[i, 0, 2], A[i, 1, 0], A[i, 1, 1], A[i, 1, 2], A[i, 2, 0], A[i, 2, 1], A[i, 2, 2])
    )
    own = (axis[i, 0], axis[i, 1], axis[i, 2])
    s = turn(R_i, own)
    step = turn(P, (translation[i, 0], translation[i, 1], translation[i, 2]))
    if links.prismatic[i]:
        step = add(step, (q * s[0], q * s[1], q * s[2]))
    else:
        R_i = product(R_i, _about(own, q))
    R[i, 0], R[i, 1], R[i, 2], R[i, 3], R[i, 4], R[i, 5], R[i, 6], R[i, 7], R[i, 8] = R_i
    d[i, 0], d[i, 1], d[i, 2] = step
    a[i, 0], a[i, 1], a[i, 2] = s
    placed.m[i] = links.mass[i]
    c[i, 0], c[i, 1], c[i, 2] = turn(R_i, (com[i, 0], com[i, 1], com[i, 2]))
    I = links.inertia  # noqa: E741 - the letter of every textbook
    body = turned(R_i, (I[i, 0, 0], I[i, 0, 1], I[i, 0, 2], I[i, 1, 1], I[i, 1, 2], I[i, 2, 2]))
    B[i, 0], B[i, 1], B[i, 2], B[i, 3], B[i, 4], B[i, 5] = body


@compiled
def _merge(i: int, j: int, d: Array, m: Array, c: Array, B: Array) -> None:
    """Add all that joint i moves to what its parent j moves."""
    # A joint that mimics another may move nothing.
    share = m[i] / (m[i] + m[j]) if m[i] > 0.0 else 0.0
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


@compiled
def momentum(placed: Placed, i: int, w: Vector, u: Vector) -> tuple[Vector, Vector]:
    """Angular momentum about joint i's origin and linear momentum of all that joint i moves, as one rigid body.

    Args:
        placed: Composite bodies.
        i: The joint.
        w: Angular velocity.
        u: Velocity of the body at the joint's origin.
    """
    c, B = placed.c, placed.B
    centre = (c[i, 0], c[i, 1], c[i, 2])
    v = add(u, cross(w, centre))
    linear = (placed.m[i] * v[0], placed.m[i] * v[1], placed.m[i] * v[2])
    angular = applied((B[i, 0], B[i, 1], B[i, 2], B[i, 3], B[i, 4], B[i, 5]), w)
    return add(cross(centre, linear), angular), linear


@compiled
def fill_mass(links: Links, armature: Array, q: Array, placed: Placed, out: Array) -> None:
    """M(q) = Sᵀ M_tree S, armature on its diagonal included, exactly symmetric; `placed` then holds composite bodies.

    Args:
        links: The tree.
        armature: Shape (nv,), kg·m².
        q: Joint values, shape (nv,), rad (m where prismatic).
        placed: Scratch.
        out: Receives M(q), shape (nv, nv), kg·m².
    """
    nv, n = q.size, links.parent.size
    parent, prismatic, a, d = links.parent, links.prismatic, placed.a, placed.d
    coordinate, ratio = links.coordinate, links.ratio
    for i in range(nv):
        for k in range(nv):
            out[i, k] = 0.0
    for i in range(n):
        _lay_out(links, i, ratio[i] * q[coordinate[i]] + links.offset[i], placed)
    for i in range(n - 1, -1, -1):
        if parent[i] >= 0:
            _merge(i, parent[i], d, placed.m, placed.c, placed.B)
        # Momentum of all that joint i moves at unit velocity, and its moment about the joint's origin.
        s = (a[i, 0], a[i, 1], a[i, 2])
        zero = (0.0, 0.0, 0.0)
        moment, linear = momentum(placed, i, zero, s) if prismatic[i] else momentum(placed, i, s, zero)
        k = i
        while k >= 0:
            # Of two joints with one coordinate both corners of M_tree, [i, k] and [k, i], fall on its diagonal.
            x, y = coordinate[i], coordinate[k]
            share = ratio[i] * ratio[k] * dot((a[k, 0], a[k, 1], a[k, 2]), linear if prismatic[k] else moment)
            out[x, y] += share
            if k != i:
                out[y, x] += share
            moment = add(moment, cross((d[k, 0], d[k, 1], d[k, 2]), linear))
            k = parent[k]
    for i in range(nv):
        out[i, i] += armature[i]


@compiled
def crba(links: Links, armature: Array, q: Array) -> Array:
    """M(q) of a batch: q (batch, nv), armature (nv,); shape (batch, nv, nv), kg·m²."""
    batch, nv = q.shape
    out = np.empty((batch, nv, nv))
    placed = scratch(links.parent.size)
    for b in range(batch):
        fill_mass(links, armature, q[b], placed, out[b])
    return out
