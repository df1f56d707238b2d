"""Where a frame of the arm is, and how the joints move it, for many configurations at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin
from numba import njit

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.arms.arm import Arm
from asmc_pin.errors import ParameterError
from asmc_pin.rigid_body.leading_axes import joint_rows
from asmc_pin.words.nearest_name import nearest


class FrameKinematics:
    """Kinematics of one frame, compiled.

    Attributes:
        frame: Its name.

    Args:
        arm: The arm.
        frame: Name of a link, or of any frame that Pinocchio finds in the URDF.
        asked_as: What the parameter is called that names it.

    Raises:
        ParameterError: There is no such frame.
    """

    def __init__(self, arm: Arm, frame: str, asked_as: str = "frame") -> None:
        model = arm.model
        if frame in arm.link_names:
            index = model.getFrameId(frame, pin.FrameType.BODY)
        elif model.existFrame(frame):
            index = model.getFrameId(frame)
        else:
            raise ParameterError(asked_as, f"no link '{frame}' in {arm.source.name}; {nearest(frame, arm.link_names)}")
        self.frame = frame
        self._joint_names = arm.joint_names
        found = model.frames[index]
        chain = []
        joint = found.parentJoint
        while joint > 0:
            chain.append(joint - 1)
            joint = model.parents[joint]
        tree = arm.tree
        self._coupling = tree.coupling
        # Copies: numba looks up a read-only array's type at every call.
        self._arrays = (
            np.array(chain[::-1], dtype=np.int64),
            *(np.array(x) for x in (tree.rotation, tree.translation, tree.axis, tree.prismatic)),
            np.array(found.placement.rotation, order="C"),
            np.array(found.placement.translation),
        )

    def poses(self, q: Array) -> Array:
        """Pose of the frame in the base frame; q of shape (..., nv), result (..., 4, 4), m."""
        lead, (rows,) = joint_rows(self._joint_names, {"q": q})
        rotation, position, _ = self._walked(rows)
        poses = np.zeros((len(rows), 4, 4))
        poses[:, :3, :3], poses[:, :3, 3], poses[:, 3, 3] = rotation, position, 1.0
        return poses.reshape(*lead, 4, 4)

    def jacobians(self, q: Array) -> Array:
        """Velocity of the frame's origin, then its angular velocity, per joint velocity, all along the base's axes.

        Args:
            q: Shape (..., nv), rad (m).

        Returns:
            Shape (..., 6, nv).
        """
        lead, (rows,) = joint_rows(self._joint_names, {"q": q})
        return self._walked(rows)[2].reshape(*lead, 6, -1)

    def joint_torques(self, q: Array, force: Array, moment: Array, local: bool = False) -> Array:
        """Joint torques Jᵀw of a wrench at the frame's origin.

        Args:
            q: Shape (batch, nv), C-ordered, rad.
            force: Shape (batch, 3), N.
            moment: Shape (batch, 3), N·m.
            local: Whether the wrench is along the frame's own axes, and not along the base's.

        Returns:
            Shape (batch, nv), N·m (N).
        """
        rotation, _, jacobian = self._walked(q)
        if local:
            force, moment = (np.einsum("bij,bj->bi", rotation, x) for x in (force, moment))
        return np.asarray(np.einsum("bij,bi->bj", jacobian, np.concatenate([force, moment], axis=1)))

    def _walked(self, q: Array) -> tuple[Array, Array, Array]:
        """Rotation (batch, 3, 3), position (batch, 3) and Jacobian (batch, 6, nv) at q (batch, nv)."""
        rotation, position, jacobian = _chain(*self._arrays, np.ascontiguousarray(self._coupling.joints(q)))
        return rotation, position, self._coupling.forces(jacobian)


@njit(cache=True, nogil=True)
def _walk(
    chain: IntArray,
    rotation: Array,
    translation: Array,
    axis: Array,
    prismatic: BoolArray,
    frame_rotation: Array,
    frame_translation: Array,
    q: Array,
) -> tuple[Array, Array, Array]:
    """Rotation (batch, 3, 3), position (batch, 3) and Jacobian (batch, 6, nv) of a frame behind a chain of joints."""
    batch, nv = q.shape
    rotations, positions, jacobians = np.empty((batch, 3, 3)), np.empty((batch, 3)), np.zeros((batch, 6, nv))
    turn, now, new, point = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    for trial in range(batch):
        now[:] = np.eye(3)
        point[:] = 0.0
        for i in chain:
            for a in range(3):
                for b in range(3):
                    point[a] += now[a, b] * translation[i, b]
            _multiply(now, rotation[i], new)
            u, angle = axis[i], q[trial, i]
            first = 0 if prismatic[i] else 3
            for a in range(3):
                for b in range(3):
                    jacobians[trial, first + a, i] += new[a, b] * u[b]
            if prismatic[i]:
                for a in range(3):
                    point[a] += jacobians[trial, a, i] * angle
                now[:] = new
            else:
                jacobians[trial, :3, i] = point  # the joint's place for now
                _rotation(u, angle, turn)
                _multiply(new, turn, now)
        for a in range(3):
            for b in range(3):
                point[a] += now[a, b] * frame_translation[b]
        _multiply(now, frame_rotation, new)
        rotations[trial], positions[trial] = new, point
        for i in chain:
            if not prismatic[i]:
                place, along = jacobians[trial, :3, i], jacobians[trial, 3:, i]
                x, y, z = point[0] - place[0], point[1] - place[1], point[2] - place[2]
                place[0] = along[1] * z - along[2] * y
                place[1] = along[2] * x - along[0] * z
                place[2] = along[0] * y - along[1] * x
    return rotations, positions, jacobians


_chain: Callable[..., tuple[Array, Array, Array]] = _walk


@njit(cache=True, nogil=True, inline="always")
def _multiply(left: Array, right: Array, out: Array) -> None:
    for a in range(3):
        for b in range(3):
            out[a, b] = left[a, 0] * right[0, b] + left[a, 1] * right[1, b] + left[a, 2] * right[2, b]


@njit(cache=True, nogil=True, inline="always")
def _rotation(u: Array, angle: float, out: Array) -> None:
    """Rodrigues' formula."""
    s, c = np.sin(angle), np.cos(angle)
    for a in range(3):
        for b in range(3):
            out[a, b] = (1.0 - c) * u[a] * u[b]
        out[a, a] += c
    out[0, 1] -= s * u[2]
    out[0, 2] += s * u[1]
    out[1, 0] += s * u[2]
    out[1, 2] -= s * u[0]
    out[2, 0] -= s * u[1]
    out[2, 1] += s * u[0]
