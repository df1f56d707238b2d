"""Mass matrices of many configurations at once."""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.rigid_body.leading_axes import joint_rows
from asmc_pin.rigid_body.recursion import crba, links_of
from asmc_pin.rigid_body.tree import Tree


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
    # A copy is always writable, so one compiled signature serves every caller.
    mass: Array = crba(links_of(tree), np.array(tree.armature), np.array(rows, order="C"))
    return mass.reshape(*lead, tree.nv, tree.nv)
