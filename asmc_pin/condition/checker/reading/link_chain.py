"""The arm of a certificate in floating point, for the replay of the boxes; rounded once, from balls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from flint import arb, arb_mat, ctx

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.condition.checker.balls.ball_geometry import about, column, normalised, rotation, still, symmetric
from asmc_pin.condition.checker.reading.coupled_joints import Following, following
from asmc_pin.condition.checker.reading.header_parts import Load
from asmc_pin.condition.checker.reading.urdf_text import Description, Unreadable, WrittenJoint
from asmc_pin.words.text import printable


@dataclass(frozen=True, eq=False)
class Chain:
    """Moving joints with what they carry; twists are (angular, linear) at the joint's frame.

    Attributes:
        parent: Shape (n,), −1 for the base.
        place: Pose of the joint's frame in its parent's at zero, shape (n, 4, 4).
        axis: Unit axis in the joint's frame, shape (n, 3).
        slides: Prismatic, shape (n,).
        inertia: Spatial inertia of all that moves with the joint, shape (n, 6, 6).
        coordinate: Of an arm with joints that follow others, the coordinate of each, shape (n,); else empty.
        ratio: By how much each follows it, shape (n,).
        offset: And from where, shape (n,), rad (m).
        leader: The joint of each coordinate, shape (nv,).
    """

    parent: IntArray
    place: Array
    axis: Array
    slides: BoolArray
    inertia: Array
    coordinate: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    ratio: Array = field(default_factory=lambda: np.empty(0))
    offset: Array = field(default_factory=lambda: np.empty(0))
    leader: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))

    @property
    def follows(self) -> bool:
        """Whether joints follow others, so that the arm has fewer coordinates than joints."""
        return self.coordinate.size > 0

    @property
    def spread(self) -> Array:
        """S with q̇_joints = S q̇, shape (n, nv)."""
        if not self.follows:
            return np.eye(self.parent.size)
        out = np.zeros((self.parent.size, self.leader.size))
        out[np.arange(self.parent.size), self.coordinate] = self.ratio
        return out

    @property
    def matters(self) -> BoolArray:
        """The coordinates that M depends on: not those that only move all of a branch, shape (nv,)."""
        carried = self.parent >= 0
        if not self.follows:
            return np.asarray(carried)
        return np.bincount(self.coordinate, carried, self.leader.size) > 0.0

    def joints(self, q: Array) -> Array:
        """Values of the joints at coordinates q, (..., nv); shape (..., n)."""
        return np.asarray(q[..., self.coordinate] * self.ratio + self.offset) if self.follows else q

    def arm_mass(self, q: Array) -> Array:
        """M of the arm at coordinates q, (..., nv), without armature; shape (..., nv, nv)."""
        S = self.spread
        return np.asarray(S.T @ self.mass_matrix(self.joints(q), np.zeros(self.parent.size)) @ S)

    @property
    def subspace(self) -> Array:
        """Twist per unit velocity of each joint, in its frame, shape (n, 6)."""
        still = np.zeros_like(self.axis)
        turning = np.concatenate((self.axis, still), axis=1)
        sliding = np.concatenate((still, self.axis), axis=1)
        return np.where(self.slides[:, None], sliding, turning)

    def transform(self, i: int, q: Array) -> Array:
        """Motion transform of joint i from its parent's frame to its own, q (...), result (..., 6, 6)."""
        placed = self.place[i]
        q = np.asarray(q, dtype=np.float64)
        if self.slides[i]:
            rotation = np.broadcast_to(placed[:3, :3], (*q.shape, 3, 3))
            origin = placed[:3, 3] + (placed[:3, :3] @ self.axis[i]) * q[..., None]
        else:
            # R = placed · exp(q axis×), by the series that ends: 1 + sin q K + (1 − cos q) K².
            K = cross(self.axis[i])
            half = np.sin(0.5 * q)[..., None, None]
            rotation = placed[:3, :3] @ (np.eye(3) + np.sin(q)[..., None, None] * K + 2.0 * half * half * (K @ K))
            origin = np.broadcast_to(placed[:3, 3], (*q.shape, 3))
        back = np.swapaxes(rotation, -1, -2)
        X = np.zeros((*q.shape, 6, 6))
        X[..., :3, :3] = X[..., 3:, 3:] = back
        X[..., 3:, :3] = -back @ cross(origin)
        return X

    def jacobians(self, q: Array) -> Array:
        """Twist of each joint's body, in its frame, by joint velocities: q (..., n), result (..., n, 6, n)."""
        n = self.parent.size
        J = np.zeros((*q.shape[:-1], n, 6, n))
        subspace = self.subspace
        for i in range(n):
            if self.parent[i] >= 0:
                J[..., i, :, :] = self.transform(i, q[..., i]) @ J[..., self.parent[i], :, :]
            J[..., i, :, i] += subspace[i]
        return J

    def mass_matrix(self, q: Array, armature: Array) -> Array:
        """M(q) as the sum of every body's Jᵀ I J, q (..., n), result (..., n, n)."""
        J = self.jacobians(q)
        return np.asarray(np.einsum("...kai,kab,...kbj->...ij", J, self.inertia, J)) + np.diag(armature)


def cross(v: Array) -> Array:
    """The matrix of v ×, v (..., 3), result (..., 3, 3)."""
    out = np.zeros((*v.shape[:-1], 3, 3))
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    return out - np.swapaxes(out, -1, -2)


def chain_of(
    robot: Description,
    joints: Sequence[str],
    locked: Mapping[str, float],
    payload: Load | None,
    moving: Sequence[str] = (),
) -> Chain:
    """The chain of a robot's moving joints: each of its numbers is the nearest float to what the decimals say.

    Poses that cancel, or a centre of mass far from its joint, would cost digits in floating point that no allowance for
    rounding speaks of; so everything up to here is done in balls.

    Args:
        robot: The robot.
        joints: Names of the joints with a coordinate, in the order of the certificate, base first.
        locked: Joints held rigid, and where, rad (m where prismatic).
        payload: What is fastened to a link of it.
        moving: Names of all joints that move, base first, where some follow others.

    Returns:
        The chain.

    Raises:
        Unreadable: The robot does not have these joints, or others that move.
    """
    with ctx.workprec(_BITS):
        return _Reader(robot, following(robot, joints, moving), locked, payload).chain()


_BITS = 256
_SURE = 1e-15
"""Largest share of a number that its ball may leave open."""
_ROUNDED, _POINT = 1.001e-9, 1.001e-12
"""What exporters' rounding may leave of an impossible inertia: a share of the largest moment, m² of gyration."""


class _Reader:
    """Walks a robot from its root, carrying poses in balls."""

    def __init__(
        self, robot: Description, follow: Following, locked: Mapping[str, float], payload: Load | None
    ) -> None:
        if payload is not None and payload.link not in robot.bodies:
            raise Unreadable(f"the payload is on link '{printable(payload.link)}', which the URDF does not have")
        self._robot, self._locked, self._payload = robot, locked, payload
        self._follow = follow
        self._index = {name: i for i, name in enumerate(follow.moving)}
        n = len(follow.moving)
        self._parent = np.full(n, -2, dtype=np.int64)
        self._slides = np.zeros(n, dtype=np.bool_)
        self._place, self._axis = np.zeros((n, 4, 4)), np.zeros((n, 3))
        self._inertia = [arb_mat(6, 6) for _ in range(n)]
        self._held: set[str] = set()

    def chain(self) -> Chain:
        waiting = [(self._robot.root, -1, *still())]
        while waiting:
            name, body, turn, place = waiting.pop()
            if body >= 0:
                self._inertia[body] += self._carried(name, turn, place)
            children = self._robot.children.get(name, ())
            waiting += [(joint.child, *self._beyond(joint, body, turn, place)) for joint in children]
        if np.any(self._parent == -2) or np.any(self._parent >= np.arange(self._parent.size)):
            raise Unreadable("the certificate's joints are not the URDF's, base first")
        if self._held != set(self._locked):
            raise Unreadable("the certificate locks joints that the URDF does not have")
        carrying = {self._led_by(i) for i, body in enumerate(self._inertia) if body[3, 3] > 0}
        for name, i in self._index.items():
            # Where all that follows one coordinate has some mass, one of its bodies needs none.
            empty = all(x == 0 for x in self._inertia[i].entries()) and self._led_by(i) in carrying
            if not empty and not _of_a_body(self._inertia[i]):
                raise Unreadable(f"what joint '{printable(name)}' of the URDF moves has an inertia that no body has")
        inertia = np.array([_floats(matrix) for matrix in self._inertia])
        follow = self._follow
        if not follow.follows:
            return Chain(self._parent, self._place, self._axis, self._slides, inertia)
        ratio, offset = (_floats(arb_mat(len(each), 1, list(each)))[:, 0] for each in (follow.ratio, follow.offset))
        coordinate, leader = (np.array(each, dtype=np.int64) for each in (follow.coordinate, follow.leader))
        return Chain(self._parent, self._place, self._axis, self._slides, inertia, coordinate, ratio, offset, leader)

    def _led_by(self, i: int) -> int:
        """The coordinate that joint i follows."""
        return self._follow.coordinate[i]

    def _beyond(self, joint: WrittenJoint, body: int, turn: arb_mat, place: arb_mat) -> tuple[int, arb_mat, arb_mat]:
        """The body that a joint's child moves with, and the child's pose in that body's frame."""
        at = place + turn * column(joint.pose.xyz)
        turned = turn * rotation(joint.pose)
        if joint.kind == "fixed":
            return body, turned, at
        along, slides = normalised(joint.axis), joint.kind == "prismatic"
        if joint.name in self._index:
            i = self._index[joint.name]
            self._parent[i], self._slides[i] = body, slides
            self._axis[i] = _floats(along)[:, 0]
            self._place[i, :3, :3], self._place[i, :3, 3], self._place[i, 3, 3] = (
                _floats(turned),
                _floats(at)[:, 0],
                1.0,
            )
            return i, *still()
        if joint.name not in self._locked:
            raise Unreadable(f"joint '{joint.name}' of the URDF moves, and the certificate neither moves nor locks it")
        self._held.add(joint.name)
        by = arb(self._locked[joint.name])
        return (body, turned, at + turned * along * by) if slides else (body, turned * about(along, by), at)

    def _carried(self, name: str, turn: arb_mat, place: arb_mat) -> arb_mat:
        """Spatial inertia of a link and of the payload on it, in the frame of the body that it moves with."""
        total = arb_mat(6, 6)
        own = self._robot.bodies[name]
        if own is not None:
            turned = turn * rotation(own.pose)
            tensor = turned * symmetric([arb(x) for x in own.inertia]) * turned.transpose()
            total += _spatial(arb(own.mass), place + turn * column(own.pose.xyz), tensor)
        if self._payload is not None and self._payload.link == name:
            load = self._payload
            tensor = turn * symmetric([arb(x) for x in load.inertia]) * turn.transpose()
            total += _spatial(arb(load.mass), place + turn * arb_mat(3, 1, [arb(x) for x in load.com]), tensor)
        return total


def _floats(matrix: arb_mat) -> Array:
    """The nearest floats to a matrix of balls.

    Raises:
        Unreadable: The balls are too wide to say.
    """
    out = np.empty((matrix.nrows(), matrix.ncols()))
    for i, j in np.ndindex(*out.shape):
        value = matrix[i, j]
        out[i, j] = float(value.mid())
        if not float(value.rad()) <= _SURE * abs(out[i, j]) + 1e-40:
            raise Unreadable("the numbers of the URDF cancel so far that nothing is left of them")
    return out


def _of_a_body(spatial: arb_mat) -> bool:
    """Whether a spatial inertia has a mass, no negative principal moment, and none above the sum of the other two.

    No statement about M(q) needs all of it: an arm that cannot be is refused as it is by whatever else reads it.
    """
    mass = spatial[3, 3]
    if not mass > 0:
        return False
    c = arb_mat([[spatial[i, 3 + j] / mass for j in range(3)] for i in range(3)])
    turning = arb_mat([[spatial[i, j] for j in range(3)] for i in range(3)]) - c * c.transpose() * mass
    least, middle, most = np.linalg.eigvalsh([[float(turning[i, j].mid()) for j in range(3)] for i in range(3)])
    slack = max(_ROUNDED * max(abs(least), abs(most)), _POINT * float(mass.mid()))
    return bool(least >= -slack and most <= least + middle + slack)


def _spatial(mass: arb, com: arb_mat, about_com: arb_mat) -> arb_mat:
    """Spatial inertia at the frame's origin: kinetic energy of a body as a form of its twist."""
    x, y, z = (com[k, 0] for k in range(3))
    c = arb_mat([[arb(0), -z, y], [z, arb(0), -x], [-y, x, arb(0)]])
    turning = about_com + c * c.transpose() * mass
    rows = [[arb(0)] * 6 for _ in range(6)]
    for i in range(3):
        rows[3 + i][3 + i] = mass
        for j in range(3):
            rows[i][j] = turning[i, j]
            rows[i][3 + j] = rows[3 + j][i] = mass * c[i, j]
    return arb_mat(rows)
