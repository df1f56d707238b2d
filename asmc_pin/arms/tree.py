"""An arm's kinematic tree as plain arrays, for compiled kernels that cannot call Pinocchio."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from asmc_pin._typing import Array, BoolArray, IntArray


@dataclass(frozen=True, eq=False)
class Tree:
    """Kinematics and inertias, joint by joint, parents before children; all arrays read-only.

    Attributes:
        parent: Index of the parent joint, −1 for the base, shape (nv,).
        rotation: Rotation of the joint's frame at q = 0, seen from its parent joint's frame, shape (nv, 3, 3).
        translation: Origin of the same, shape (nv, 3), m.
        axis: Unit axis in the joint's frame, shape (nv, 3).
        prismatic: Whether the joint slides, shape (nv,).
        mass: Mass that moves with the joint, up to the next one, shape (nv,), kg.
        com: Its centre in the joint's frame, shape (nv, 3), m.
        inertia: Its inertia about that centre, in the joint's axes, shape (nv, 3, 3), kg·m².
        armature: Reflected rotor inertia, shape (nv,), kg·m² (kg where prismatic).
        gravity: Acceleration of gravity in the base frame, shape (3,), m/s².
    """

    parent: IntArray
    rotation: Array
    translation: Array
    axis: Array
    prismatic: BoolArray
    mass: Array
    com: Array
    inertia: Array
    armature: Array
    gravity: Array

    @property
    def nv(self) -> int:
        """Number of joints."""
        return self.parent.size


def tree_of(model: pin.Model) -> Tree:
    """Read the tree off a Pinocchio model whose joints are all unbounded revolute or prismatic, one coordinate each."""
    data = model.createData()
    pin.computeJointJacobians(model, data, np.zeros(model.nq))
    joints = range(1, model.njoints)
    # The local Jacobian's own column is the joint's motion subspace, whatever Pinocchio calls the joint's type. Of an
    # arm with one joint eigenpy hands the Jacobian over as a vector.
    jacobians = [pin.getJointJacobian(model, data, j, pin.LOCAL).reshape(6, model.nv) for j in joints]
    motion = np.array([jacobian[:, model.idx_vs[j]] for jacobian, j in zip(jacobians, joints, strict=True)])
    prismatic = np.any(motion[:, :3] != 0.0, axis=1)
    arrays = {
        "parent": np.array([model.parents[j] - 1 for j in joints], dtype=np.int64),
        "rotation": np.array([model.jointPlacements[j].rotation for j in joints]),
        "translation": np.array([model.jointPlacements[j].translation for j in joints]),
        "axis": np.where(prismatic[:, None], motion[:, :3], motion[:, 3:]),
        "prismatic": prismatic,
        "mass": np.array([model.inertias[j].mass for j in joints]),
        "com": np.array([model.inertias[j].lever for j in joints]),
        "inertia": np.array([model.inertias[j].inertia for j in joints]),
        "armature": np.array(model.armature),
        "gravity": np.array(model.gravity.linear),
    }
    for name, value in arrays.items():
        arrays[name] = np.ascontiguousarray(value)
        arrays[name].setflags(write=False)
    return Tree(**arrays)
