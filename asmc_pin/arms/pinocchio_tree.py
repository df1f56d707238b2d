"""Pinocchio's model as plain arrays, for compiled code that cannot call Pinocchio."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from asmc_pin.rigid_body.coupling import Coupling
from asmc_pin.rigid_body.tree import Tree


def tree_of(model: pin.Model, coupling: Coupling) -> Tree:
    """Read the tree off a Pinocchio model whose joints are all unbounded revolute or prismatic.

    Args:
        model: With one coordinate for every joint, those that mimic others included.
        coupling: How the joints follow the arm's coordinates.
    """
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
        "armature": coupling.forces(coupling.ratio * model.armature),
        "gravity": np.array(model.gravity.linear),
    }
    for name, value in arrays.items():
        arrays[name] = np.ascontiguousarray(value)
        arrays[name].setflags(write=False)
    return Tree(**arrays, coupling=coupling)
