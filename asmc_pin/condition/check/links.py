"""The arm of a certificate in floating point, for the replay of the boxes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.condition.check.contents import Load
from asmc_pin.condition.check.urdf_text import Body, Decimals, Description, Pose, Unreadable
from asmc_pin.text import printable


@dataclass(frozen=True, eq=False)
class Chain:
    """Moving joints with what they carry; twists are (angular, linear) at the joint's frame.

    Attributes:
        parent: Shape (n,), −1 for the base.
        place: Pose of the joint's frame in its parent's at zero, shape (n, 4, 4).
        axis: Unit axis in the joint's frame, shape (n, 3).
        slides: Prismatic, shape (n,).
        inertia: Spatial inertia of all that moves with the joint, shape (n, 6, 6).
    """

    parent: IntArray
    place: Array
    axis: Array
    slides: BoolArray
    inertia: Array

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


def chain_of(robot: Description, joints: Sequence[str], locked: Mapping[str, float], payload: Load | None) -> Chain:
    """The chain of a robot's moving joints.

    Args:
        robot: The robot.
        joints: Names of the moving joints, in the order of the certificate, base first.
        locked: Joints held rigid, and where, rad (m where prismatic).
        payload: What is fastened to a link of it.

    Returns:
        The chain.

    Raises:
        Unreadable: The robot does not have these joints, or others that move.
    """
    index = {name: i for i, name in enumerate(joints)}
    n = len(joints)
    parent, place = np.full(n, -2, dtype=np.int64), np.zeros((n, 4, 4))
    axis, slides, inertia = np.zeros((n, 3)), np.zeros(n, dtype=np.bool_), np.zeros((n, 6, 6))
    held = set()
    if payload is not None and payload.link not in robot.bodies:
        raise Unreadable(f"the payload is on link '{printable(payload.link)}', which the URDF does not have")
    waiting = [(robot.root, -1, np.eye(4))]
    while waiting:
        name, body, pose = waiting.pop()
        if body >= 0:
            own = robot.bodies[name]
            if own is not None:
                inertia[body] += _moved(pose, _inertia(own))
            if payload is not None and payload.link == name:
                load = _spatial(payload.mass, np.array(payload.com), _symmetric(np.array(payload.inertia)))
                inertia[body] += _moved(pose, load)
        for joint in robot.children.get(name, ()):
            at, along, moves = pose @ _origin(joint.pose), _axis(joint.axis), joint.kind != "fixed"
            if moves and joint.name in index:
                if joint.mimics:
                    raise Unreadable(
                        f"joint '{printable(joint.name)}' of the URDF follows another, which is not checked"
                    )
                i = index[joint.name]
                parent[i], place[i], axis[i], slides[i] = body, at, along, joint.kind == "prismatic"
                waiting.append((joint.child, i, np.eye(4)))
                continue
            if moves:
                if joint.name not in locked:
                    raise Unreadable(
                        f"joint '{printable(joint.name)}' of the URDF moves, and the certificate neither moves nor "
                        "locks it"
                    )
                held.add(joint.name)
                at = at @ _motion(along, locked[joint.name], joint.kind == "prismatic")
            waiting.append((joint.child, body, at))
    if np.any(parent == -2) or np.any(parent >= np.arange(n)):
        raise Unreadable("the certificate's joints are not the URDF's, base first")
    if held != set(locked):
        raise Unreadable("the certificate locks joints that the URDF does not have")
    return Chain(parent, place, axis, slides, inertia)


def _floats(values: Decimals) -> Array:
    return np.array([float(x) for x in values])


def _axis(axis: Decimals) -> Array:
    along = _floats(axis)
    length = float(np.linalg.norm(along))
    return along / length if length > 0.0 else along


def _origin(origin: Pose) -> Array:
    pose = np.eye(4)
    pose[:3, 3] = _floats(origin.xyz)
    roll, pitch, yaw = _floats(origin.rpy)
    pose[:3, :3] = _turn(2, yaw) @ _turn(1, pitch) @ _turn(0, roll)
    return pose


def _turn(axis: int, angle: float) -> Array:
    return _motion(np.eye(3)[axis], angle, False)[:3, :3]


def _motion(axis: Array, q: float, slides: bool) -> Array:
    pose = np.eye(4)
    if slides:
        pose[:3, 3] = axis * q
    else:
        K = cross(axis)
        pose[:3, :3] = np.eye(3) + np.sin(q) * K + (1.0 - np.cos(q)) * K @ K
    return pose


def _inertia(body: Body) -> Array:
    pose = _origin(body.pose)
    about = pose[:3, :3] @ _symmetric(_floats(body.inertia)) @ pose[:3, :3].T
    return _spatial(float(body.mass), pose[:3, 3], about)


def _symmetric(entries: Array) -> Array:
    xx, xy, xz, yy, yz, zz = entries
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _spatial(mass: float, com: Array, about_com: Array) -> Array:
    """Spatial inertia at the frame's origin: kinetic energy of a body as a form of its twist."""
    c = cross(com)
    out = np.empty((6, 6))
    out[:3, :3] = about_com + mass * c @ c.T
    out[:3, 3:], out[3:, :3] = mass * c, mass * c.T
    out[3:, 3:] = mass * np.eye(3)
    return out


def _moved(pose: Array, inertia: Array) -> Array:
    """An inertia in a frame at `pose`, seen from the frame that the pose is in."""
    X = np.zeros((6, 6))
    back = pose[:3, :3].T
    X[:3, :3] = X[3:, 3:] = back
    X[3:, :3] = -back @ cross(pose[:3, 3])
    return X.T @ inertia @ X
