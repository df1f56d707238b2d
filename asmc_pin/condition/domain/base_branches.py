"""Branches of an arm that hang on the base one by one: M(q) is block diagonal, and each block is a problem of its own.

The inertia of a branch does not depend on the joints of another. M̄ is diagonal, so N M + M N, M − M̄ and every other
matrix of a statement falls into the same blocks: it is positive definite exactly when each block is.
"""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import IntArray
from asmc_pin.rigid_body.tree import Tree


def branches(parent: IntArray) -> list[IntArray]:
    """The joints of each branch, in the order of their first joints.

    Args:
        parent: Index of each joint's parent, −1 for the base, parents before children, shape (nv,).

    Returns:
        Indices of joints, each ascending; one array for an arm with one joint on the base.
    """
    root = np.arange(len(parent))
    for i, before in enumerate(parent):
        if before >= 0:
            root[i] = root[before]
    return [np.flatnonzero(root == first) for first in np.flatnonzero(np.asarray(parent) < 0)]


def branch_of(tree: Tree, joints: IntArray) -> Tree:
    """The tree of one branch alone."""
    if len(joints) == tree.nv:
        return tree
    place = np.full(tree.nv + 1, -1)  # the last entry is that of the base, −1
    place[joints] = np.arange(len(joints))
    return Tree(
        parent=place[tree.parent[joints]],
        rotation=tree.rotation[joints],
        translation=tree.translation[joints],
        axis=tree.axis[joints],
        prismatic=tree.prismatic[joints],
        mass=tree.mass[joints],
        com=tree.com[joints],
        inertia=tree.inertia[joints],
        armature=tree.armature[joints],
        gravity=tree.gravity,
    )
