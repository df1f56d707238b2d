"""The dynamics of an arm, by Pinocchio: equation (1) of Baek (2016) without friction, over any leading axes."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pinocchio as pin

from asmc_pin._typing import Array
from asmc_pin.arms.urdf.urdf_reading import Mimic
from asmc_pin.errors import ParameterError
from asmc_pin.rigid_body.leading_axes import joint_rows
from asmc_pin.rigid_body.tree import Tree


class ArmDynamics:
    """What an arm does: M, C, g and their like at joint values, batched over leading axes.

    Attributes:
        joint_names: Driven joints, base first.
        link_names: All links, those behind fixed and locked joints included.
        mimics: Joints that move with a driven one.
        armature: Reflected rotor inertia, shape (nv,).
        model: Pinocchio's model, one coordinate for every joint that moves, mimicking ones included.
        tree: The same in plain arrays.
    """

    joint_names: tuple[str, ...]
    link_names: tuple[str, ...]
    mimics: Mapping[str, Mimic]
    armature: Array
    model: pin.Model
    tree: Tree
    _local: threading.local

    @property
    def nv(self) -> int:
        """Number of driven joints."""
        return len(self.joint_names)

    def mass_matrix(self, q: Array) -> Array:
        """Joint-space inertia M(q), armature included.

        Args:
            q: Shape (..., nv).

        Returns:
            Shape (..., nv, nv), exactly symmetric.
        """
        mass = self._batched(pin.crba, (self.model.nv, self.model.nv), q=q)
        if not self.mimics:
            return mass
        mass = self.tree.coupling.form(mass)
        return np.asarray(0.5 * (mass + mass.swapaxes(-1, -2)))

    def coriolis(self, q: Array, v: Array) -> Array:
        """The matrix C(q, q̇) of Christoffel symbols: C q̇ is the Coriolis torque, and Ṁ − 2C is skew-symmetric.

        Args:
            q: Shape (..., nv).
            v: Shape (..., nv).

        Returns:
            Shape (..., nv, nv).
        """
        # S does not change, so the symbols of SᵀMS are those of M, and no term comes of S.
        return self.tree.coupling.form(
            self._batched(pin.computeCoriolisMatrix, (self.model.nv, self.model.nv), q=q, v=v)
        )

    def gravity(self, q: Array) -> Array:
        """Torque g(q) that holds the arm against gravity.

        Args:
            q: Shape (..., nv).

        Returns:
            Shape (..., nv).
        """
        return self.tree.coupling.forces(self._batched(pin.computeGeneralizedGravity, (self.model.nv,), q=q))

    def bias(self, q: Array, v: Array) -> Array:
        """C(q, q̇) q̇ + g(q), without friction.

        Args:
            q: Shape (..., nv).
            v: Shape (..., nv).

        Returns:
            Shape (..., nv).
        """
        return self.tree.coupling.forces(self._batched(pin.nonLinearEffects, (self.model.nv,), q=q, v=v))

    @property
    def inertial_parameters(self) -> Array:
        """What `regressor` multiplies: ten for each moving link, from the base on, then the armature of each joint.

        A link's are mass, mass × centre of mass (3) and the inertia about the joint's frame (xx, xy, yy, xz, yz, zz).
        """
        links = [inertia.toDynamicParameters() for inertia in list(self.model.inertias)[1:]]
        return np.concatenate([*links, self.armature])

    def regressor(self, q: Array, v: Array, v_r: Array, a_r: Array) -> Array:
        """The matrix Y with Y θ = M(q) a_r + C(q, v) v_r + g(q), θ the `inertial_parameters`.

        C is that of Christoffel symbols, so that C(q, x) y is bilinear and symmetric in x and y: it is a quarter of the
        difference of C(q, x + y)(x + y) and C(q, x − y)(x − y), of which Pinocchio has regressors.

        Args:
            q: Shape (..., nv).
            v: Velocity, shape (..., nv).
            v_r: Reference velocity of Slotine and Li, shape (..., nv).
            a_r: Reference acceleration, shape (..., nv).

        Returns:
            Shape (..., nv, 10 links + nv).

        Raises:
            ParameterError: a joint mimics another: Pinocchio's regressor knows no such joint.
        """
        if self.mimics:
            raise ParameterError(
                "arm",
                "has joints that mimic others, for which there is no regressor; lock the joint that they follow, or "
                "take a law that needs none",
            )
        still = np.zeros(self.nv)

        def rows(model: pin.Model, data: pin.Data, q: Array, v: Array, v_r: Array, a_r: Array) -> Array:
            def part(velocity: Array, acceleration: Array) -> Array:
                return np.array(pin.computeJointTorqueRegressor(model, data, q, velocity, acceleration))

            if np.array_equal(v, v_r):  # what Pinocchio has, three times as quick
                return np.concatenate([part(v, a_r), np.diag(a_r)], axis=1)
            links = part(still, a_r) + 0.25 * (part(v + v_r, still) - part(v - v_r, still))
            return np.concatenate([links, np.diag(a_r)], axis=1)

        return self._batched(rows, (self.nv, self.inertial_parameters.size), q=q, v=v, v_r=v_r, a_r=a_r)

    def forward_dynamics(self, q: Array, v: Array, torque: Array) -> Array:
        """Acceleration M⁻¹(τ − C q̇ − g), without friction.

        Args:
            q: Shape (..., nv).
            v: Shape (..., nv).
            torque: Shape (..., nv).

        Returns:
            Shape (..., nv).
        """
        if not self.mimics:
            return self._batched(pin.aba, (self.nv,), q=q, v=v, torque=torque)
        # Pinocchio's aba knows no joint that follows another: M and the forces are projected, and solved for.
        lead, (q, v, torque) = joint_rows(self.joint_names, {"q": q, "v": v, "torque": torque})
        left = torque - self.bias(q, v)
        return np.asarray(np.linalg.solve(self.mass_matrix(q), left[..., None])[..., 0].reshape(*lead, self.nv))

    def link_poses(self, q: Array) -> Array:
        """Pose of every link in the base frame, in the order of `link_names`.

        Args:
            q: Shape (..., nv).

        Returns:
            Homogeneous matrices, shape (..., nlinks, 4, 4), m.
        """
        frames = [self.model.getFrameId(name, pin.FrameType.BODY) for name in self.link_names]

        def poses(model: pin.Model, data: pin.Data, q: Array) -> list[Array]:
            pin.framesForwardKinematics(model, data, q)
            return [data.oMf[frame].homogeneous for frame in frames]

        return self._batched(poses, (len(frames), 4, 4), q=q)

    def _batched(self, function: Callable[..., Any], shape: tuple[int, ...], **arguments: Array) -> Array:
        """Apply a Pinocchio function over the leading axes of its arguments, which broadcast, joint by joint."""
        lead, rows = joint_rows(self.joint_names, arguments)
        to_joints = {"q": self.tree.coupling.joints, "v": self.tree.coupling.rates}
        rows = [to_joints.get(name, np.asarray)(row) for name, row in zip(arguments, rows, strict=True)]
        out = np.empty((rows[0].shape[0], *shape))
        data = self._data()
        for k, row in enumerate(zip(*rows, strict=True)):
            out[k] = function(self.model, data, *row)
        return out.reshape(*lead, *shape)

    def _data(self) -> pin.Data:
        """Pinocchio's scratch memory, one per thread."""
        data = getattr(self._local, "data", None)
        if data is None:
            data = self._local.data = self.model.createData()
        return data
