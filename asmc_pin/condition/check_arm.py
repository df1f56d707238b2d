"""The arm of a certificate, read from its URDF's text without Pinocchio and without the loader.

Written a second time on purpose: a checker that reads the arm as the prover did repeats its mistakes.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin._typing import Array, BoolArray, IntArray


class Unreadable(ValueError):
    """The text does not describe the arm that the certificate speaks of; the message says why."""


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


def chain_of_text(
    text: str, joints: Sequence[str], locked: Mapping[str, float], payload: Mapping[str, Any] | None
) -> Chain:
    """Read a URDF.

    Args:
        text: The file.
        joints: Names of the moving joints, in the order of the certificate.
        locked: Joints held rigid, and where, rad (m where prismatic).
        payload: ``mass``, ``com``, ``inertia`` (six entries) and ``link``; None for nothing.

    Returns:
        The chain.

    Raises:
        Unreadable: It is not well-formed, or does not have these joints.
    """
    if "<!ENTITY" in text:
        raise Unreadable("the URDF declares entities, which are not expanded here")
    try:
        root = ET.fromstring(text.encode())
    except ET.ParseError as error:
        raise Unreadable(f"the URDF is not well-formed XML: {error}") from None
    for element in root.iter():
        element.tag = str(element.tag).rpartition("}")[2]
    index = {name: i for i, name in enumerate(joints)}
    n = len(joints)
    parent, place = np.full(n, -2, dtype=np.int64), np.zeros((n, 4, 4))
    axis, slides, inertia = np.zeros((n, 3)), np.zeros(n, dtype=np.bool_), np.zeros((n, 6, 6))
    children: dict[str, list[ET.Element]] = {}
    below = set()
    for joint in root.findall("joint"):
        children.setdefault(_part(joint, "parent").get("link", ""), []).append(joint)
        below.add(_part(joint, "child").get("link", ""))
    links = {link.get("name", ""): link for link in root.findall("link")}
    open_links = [(name, -1, np.eye(4)) for name in links if name not in below]
    while open_links:
        name, body, pose = open_links.pop()
        if body >= 0:
            inertia[body] += _moved(pose, _link_inertia(links[name]))
            if payload is not None and payload["link"] == name:
                inertia[body] += _moved(pose, _spatial(payload["mass"], payload["com"], _symmetric(payload["inertia"])))
        for joint in children.get(name, []):
            child, label = _part(joint, "child").get("link", ""), joint.get("name", "")
            kind, at = joint.get("type"), pose @ _origin(joint)
            along = _axis(joint)
            if label in index:
                i = index[label]
                parent[i], place[i], axis[i], slides[i] = body, at, along, kind == "prismatic"
                open_links.append((child, i, np.eye(4)))
                continue
            if kind != "fixed":
                if label not in locked:
                    raise Unreadable(
                        f"joint '{label}' of the URDF moves, and the certificate neither moves nor locks it"
                    )
                at = at @ _motion(along, float(locked[label]), kind == "prismatic")
            open_links.append((child, body, at))
    if np.any(parent == -2) or np.any(parent >= np.arange(n)):
        raise Unreadable("the certificate's joints are not the URDF's, base first")
    return Chain(parent, place, axis, slides, inertia)


def _part(element: ET.Element, tag: str) -> ET.Element:
    found = element.find(tag)
    if found is None:
        raise Unreadable(f"joint '{element.get('name')}' of the URDF has no <{tag}>")
    return found


def _numbers(text: str | None, default: str) -> Array:
    try:
        return np.array([float(x) for x in (text or default).split()])
    except ValueError:
        raise Unreadable(f"'{text}' in the URDF is not a row of numbers") from None


def _axis(joint: ET.Element) -> Array:
    element = joint.find("axis")
    along = _numbers(None if element is None else element.get("xyz"), "1 0 0")
    length = float(np.linalg.norm(along))
    return along / length if length > 0.0 else along


def _origin(element: ET.Element) -> Array:
    pose = np.eye(4)
    origin = element.find("origin")
    if origin is not None:
        pose[:3, 3] = _numbers(origin.get("xyz"), "0 0 0")
        roll, pitch, yaw = _numbers(origin.get("rpy"), "0 0 0")
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


def _link_inertia(link: ET.Element) -> Array:
    inertial = link.find("inertial")
    if inertial is None:
        return np.zeros((6, 6))
    mass, tensor = inertial.find("mass"), inertial.find("inertia")
    value = 0.0 if mass is None else float(mass.get("value", "0"))
    entries = [
        0.0 if tensor is None else float(tensor.get(key, "0")) for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    ]
    pose = _origin(inertial)
    about = pose[:3, :3] @ _symmetric(entries) @ pose[:3, :3].T
    return _spatial(value, pose[:3, 3], about)


def _symmetric(entries: Sequence[float] | Array) -> Array:
    xx, xy, xz, yy, yz, zz = entries
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _spatial(mass: float, com: Array | Sequence[float], about_com: Array) -> Array:
    """Spatial inertia at the frame's origin: kinetic energy of a body as a form of its twist."""
    c = cross(np.asarray(com, dtype=np.float64))
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
