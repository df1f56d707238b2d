"""M(q) and the bias C(q, v) v + g(q) of one configuration in one pass outward and one inward, compiled.

Newton and Euler's equations link by link and composite bodies, in the frames of `recursion`: the base's axes, each
vector from its joint's own origin. Gravity is an acceleration of the base upwards. Featherstone, Rigid Body Dynamics
Algorithms (2008), chapters 5 and 6.

All numbers of a link stand in one row of an array, and so do all that is computed for it: a function that is handed
one array does not count references to a dozen.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from asmc_pin._typing import Array, IntArray
from asmc_pin.numerics.short_loops import inlined, short_loops, with_room
from asmc_pin.rigid_body.recursion import (
    Matrix,
    Symmetric,
    Vector,
    add,
    applied,
    cross,
    dot,
    product,
    turn,
    turned,
)
from asmc_pin.rigid_body.tree import Tree

# Columns of `Bodies.body`. A turning joint's frame in its parent's is REST + sin q·SINE + (1 − cos q)·COSINE.
_REST, _SINE, _COSINE, _ORIGIN, _AXIS, _MASS, _CENTRE, _INERTIA, _ARMATURE, _SLIDES = (
    0,
    9,
    18,
    27,
    30,
    33,
    34,
    37,
    43,
    44,
)
_COLUMNS = 45

# Columns of the scratch array: orientation, step from the parent's origin, axis; angular velocity, its rate, and
# acceleration of the origin; force and moment on the body; mass, centre and inertia of all that the joint moves.
_R, _D, _A, _W, _TURN, _LINEAR, _FORCE, _MOMENT, _M, _C, _B = 0, 9, 12, 15, 18, 21, 24, 27, 30, 31, 34
ROOM = 40
"""Columns of the scratch array of `fill_dynamics`."""


class Bodies(NamedTuple):
    """A tree of links in the form that `fill_dynamics` takes.

    Attributes:
        parent: Index of the parent joint, −1 for the base, shape (nv,).
        body: The numbers of each joint and its link, shape (nv, 45).
        gravity: Acceleration of gravity in the base frame, shape (3,), m/s².
    """

    parent: IntArray
    body: Array
    gravity: Array


def bodies_of(tree: Tree) -> Bodies:
    """The compiled form of a tree."""
    body = np.zeros((tree.nv, _COLUMNS))
    x, y, z = tree.axis.T
    zero = np.zeros_like(x)
    K = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    turns = ~tree.prismatic[:, None]
    body[:, _REST : _REST + 9] = tree.rotation.reshape(-1, 9)
    body[:, _SINE : _SINE + 9] = turns * (tree.rotation @ K).reshape(-1, 9)
    body[:, _COSINE : _COSINE + 9] = turns * (tree.rotation @ K @ K).reshape(-1, 9)
    body[:, _ORIGIN : _ORIGIN + 3] = tree.translation
    body[:, _AXIS : _AXIS + 3] = (tree.rotation @ tree.axis[:, :, None])[:, :, 0]
    body[:, _MASS] = tree.mass
    body[:, _CENTRE : _CENTRE + 3] = tree.com
    body[:, _INERTIA : _INERTIA + 6] = tree.inertia[:, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]
    body[:, _ARMATURE] = tree.armature
    body[:, _SLIDES] = tree.prismatic
    return Bodies(np.array(tree.parent), body, np.array(tree.gravity))


@inlined
def _vector(x: Array, i: int, at: int) -> Vector:
    return x[i, at], x[i, at + 1], x[i, at + 2]


@inlined
def _symmetric(x: Array, i: int, at: int) -> Symmetric:
    return x[i, at], x[i, at + 1], x[i, at + 2], x[i, at + 3], x[i, at + 4], x[i, at + 5]


@inlined
def _matrix(x: Array, i: int, at: int) -> Matrix:
    x0, x1, x2 = _vector(x, i, at)
    x3, x4, x5 = _vector(x, i, at + 3)
    x6, x7, x8 = _vector(x, i, at + 6)
    return x0, x1, x2, x3, x4, x5, x6, x7, x8


@inlined
def _put(x: Array, i: int, at: int, value: Vector) -> None:
    x[i, at], x[i, at + 1], x[i, at + 2] = value


@inlined
def _add_to(x: Array, i: int, at: int, value: Vector) -> None:
    x[i, at] += value[0]
    x[i, at + 1] += value[1]
    x[i, at + 2] += value[2]


@inlined
def _times(factor: float, x: Vector) -> Vector:
    return factor * x[0], factor * x[1], factor * x[2]


@inlined
def _blend(A: Matrix, s: float, B: Matrix, c: float, C: Matrix) -> Matrix:
    """A + s B + c C."""
    return (
        A[0] + s * B[0] + c * C[0],
        A[1] + s * B[1] + c * C[1],
        A[2] + s * B[2] + c * C[2],
        A[3] + s * B[3] + c * C[3],
        A[4] + s * B[4] + c * C[4],
        A[5] + s * B[5] + c * C[5],
        A[6] + s * B[6] + c * C[6],
        A[7] + s * B[7] + c * C[7],
        A[8] + s * B[8] + c * C[8],
    )


@inlined
def _outward(parent: IntArray, body: Array, gravity: Array, q: float, v: float, i: int, room: Array) -> None:
    """Place joint i, and move it: its row of the scratch array, from its parent's."""
    j = parent[i]
    P = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    w, turning, linear = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (-gravity[0], -gravity[1], -gravity[2])
    if j >= 0:
        P = _matrix(room, j, _R)
        w, turning, linear = _vector(room, j, _W), _vector(room, j, _TURN), _vector(room, j, _LINEAR)
    slides = body[i, _SLIDES] != 0.0
    axis = turn(P, _vector(body, i, _AXIS))
    step = turn(P, _vector(body, i, _ORIGIN))
    own = _times(v, axis)
    swept = cross(w, own)
    R = _matrix(body, i, _REST)
    if slides:
        step = add(step, _times(q, axis))
    else:
        s, c = np.sin(q), 1.0 - np.cos(q)
        R = _blend(R, s, _matrix(body, i, _SINE), c, _matrix(body, i, _COSINE))
    R = product(P, R)
    linear = add(linear, add(cross(turning, step), cross(w, cross(w, step))))
    if slides:
        linear = add(linear, _times(2.0, swept))
    else:
        turning, w = add(turning, swept), add(w, own)
    centre = turn(R, _vector(body, i, _CENTRE))
    inertia = turned(R, _symmetric(body, i, _INERTIA))
    force = _times(body[i, _MASS], add(linear, add(cross(turning, centre), cross(w, cross(w, centre)))))
    moment = add(add(applied(inertia, turning), cross(w, applied(inertia, w))), cross(centre, force))
    _put(room, i, _R, (R[0], R[1], R[2]))
    _put(room, i, _R + 3, (R[3], R[4], R[5]))
    _put(room, i, _R + 6, (R[6], R[7], R[8]))
    _put(room, i, _D, step)
    _put(room, i, _A, axis)
    _put(room, i, _W, w)
    _put(room, i, _TURN, turning)
    _put(room, i, _LINEAR, linear)
    _put(room, i, _FORCE, force)
    _put(room, i, _MOMENT, moment)
    room[i, _M] = body[i, _MASS]
    _put(room, i, _C, centre)
    _put(room, i, _B, (inertia[0], inertia[1], inertia[2]))
    _put(room, i, _B + 3, (inertia[3], inertia[4], inertia[5]))


@inlined
def _hand_on(i: int, j: int, room: Array) -> None:
    """Add what joint i moves, and the force and moment on it, to what its parent j has."""
    force, step = _vector(room, i, _FORCE), _vector(room, i, _D)
    _add_to(room, j, _FORCE, force)
    _add_to(room, j, _MOMENT, add(_vector(room, i, _MOMENT), cross(step, force)))
    m, n = room[i, _M], room[j, _M]
    share = m / (m + n)
    centre, at = _vector(room, i, _C), _vector(room, j, _C)
    x, y, z = step[0] + centre[0] - at[0], step[1] + centre[1] - at[1], step[2] + centre[2] - at[2]
    w = share * n
    room[j, _M] = n + m
    _add_to(room, j, _C, (share * x, share * y, share * z))
    own = _symmetric(room, i, _B)
    _add_to(room, j, _B, (own[0] + w * (y * y + z * z), own[1] - w * x * y, own[2] - w * x * z))
    _add_to(room, j, _B + 3, (own[3] + w * (x * x + z * z), own[4] - w * y * z, own[5] + w * (x * x + y * y)))


@short_loops
def fill_dynamics(
    parent: IntArray, body: Array, gravity: Array, q: Array, v: Array, room: Array, mass: Array, bias: Array
) -> None:
    """M(q), armature included, exactly symmetric, and C(q, v) v + g(q).

    Args:
        parent: Of the `Bodies`.
        body: Of the `Bodies`.
        gravity: Of the `Bodies`.
        q: Joint values, shape (nv,), rad (m where prismatic).
        v: Their velocities.
        room: Scratch, shape (nv, ROOM).
        mass: Receives M(q), shape (nv, nv), kg·m²; what joints of separate branches share is 0 and is not written.
        bias: Receives C v + g, shape (nv,), N·m.
    """
    nv = q.size
    for i in range(nv):
        _outward(parent, body, gravity, q[i], v[i], i, room)
    for i in range(nv - 1, -1, -1):
        slides = body[i, _SLIDES] != 0.0
        axis = _vector(room, i, _A)
        bias[i] = dot(axis, _vector(room, i, _FORCE) if slides else _vector(room, i, _MOMENT))
        if parent[i] >= 0:
            _hand_on(i, parent[i], room)
        # Momentum of all that joint i moves at unit velocity, and its moment about the joint's origin.
        centre = _vector(room, i, _C)
        linear = _times(room[i, _M], axis if slides else cross(axis, centre))
        moment = cross(centre, linear)
        if not slides:
            moment = add(moment, applied(_symmetric(room, i, _B), axis))
        k = i
        while k >= 0:
            entry = dot(_vector(room, k, _A), linear if body[k, _SLIDES] != 0.0 else moment)
            mass[i, k] = entry
            mass[k, i] = entry
            moment = add(moment, cross(_vector(room, k, _D), linear))
            k = parent[k]
        mass[i, i] += body[i, _ARMATURE]


@with_room
def dynamics(bodies: Bodies, q: Array, v: Array) -> tuple[Array, Array]:
    """M(q), (batch, nv, nv), and C v + g, (batch, nv), of a batch; q and v of shape (batch, nv)."""
    batch, nv = q.shape
    mass, bias = np.zeros((batch, nv, nv)), np.empty((batch, nv))
    room = np.empty((nv, ROOM))
    for b in range(batch):
        fill_dynamics(bodies.parent, bodies.body, bodies.gravity, q[b], v[b], room, mass[b], bias[b])
    return mass, bias
